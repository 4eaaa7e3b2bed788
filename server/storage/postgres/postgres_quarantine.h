// The records in PostgreSQL that wait to be promoted. They are in a table of their own, which is in
// no sum. They are changed in the transaction of the caller, who has locked their sources.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_evidence.h"

namespace sweepstake::storage {

// Records taken out of the quarantine: whole amounts, not changes.
struct QuarantinedRows {
  RowChanges rows;
  std::set<int64_t> scenes;  // their scenes
  uint64_t window_count = 0;
};

class PostgresQuarantine {
 public:
  // `connection` must outlive it.
  explicit PostgresQuarantine(PostgresConnection& connection) : connection_(connection) {}

  // Returns the rows that wait. Missing ones are left out.
  absl::StatusOr<RowChanges> Load(const std::set<RowPlace>& places);
  // Adds the rows, or replaces older rows of their keys and sources.
  absl::Status Put(const RowChanges& rows);
  // Error: RESOURCE_EXHAUSTED (more than `max_rows` wait). Rows that other daemons add at the same
  // time are not counted.
  absl::Status CheckSize(uint64_t max_rows);
  // Removes what is not newer than the given rows of the same key and source.
  absl::Status Drop(const RowChanges& newer);
  // Takes out all rows of the sources about a project, or about all projects if that is empty.
  absl::StatusOr<QuarantinedRows> TakeOut(const PostgresArray& sources, const std::string& project);

 private:
  PostgresConnection& connection_;
};

}  // namespace sweepstake::storage
