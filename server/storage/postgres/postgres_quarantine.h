// The records in PostgreSQL that wait to be promoted, changed within the transaction of whoever
// calls, who has locked their sources. They are in a table of their own, which no sum has.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_evidence.h"

namespace sweepstake::storage {

// What was taken out of the quarantine: whole amounts, not changes.
struct QuarantinedRows {
  RowChanges rows;
  std::set<int64_t> scenes;  // that they are about
  uint64_t window_count = 0;
};

class PostgresQuarantine {
 public:
  // `connection` must outlive it.
  explicit PostgresQuarantine(PostgresConnection& connection) : connection_(connection) {}

  // Returns what waits; what does not is left out.
  absl::StatusOr<RowChanges> Load(const std::set<RowPlace>& places);
  // Puts the rows in, where they are in the place of older ones of their key and source.
  absl::Status Put(const RowChanges& rows);
  // Error: RESOURCE_EXHAUSTED (more than so many rows wait). What other daemons put in at the same
  // time is not counted.
  absl::Status CheckSize(uint64_t max_rows);
  // Removes what is no newer than the rows of the same key and source.
  absl::Status Drop(const RowChanges& newer);
  // Takes out all that waits of the sources about a project, or all if that is empty.
  absl::StatusOr<QuarantinedRows> TakeOut(const PostgresArray& sources, const std::string& project);

 private:
  PostgresConnection& connection_;
};

}  // namespace sweepstake::storage
