// The audit log in the prior store's SQLite file: a table of segments and a table of their rows.
// Used by one thread at a time; the database must outlive it.
//
// The space of removed rows is used again, but the file does not shrink.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/priors/prior_store.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

class SqliteAuditLog {
 public:
  static absl::StatusOr<SqliteAuditLog> Open(SqliteDatabase& database,
                                             const priors::AuditLimits& limits);

  // Appends all rows or none, inside the caller's transaction; after an error the transaction is as
  // before. If the transaction is committed, the caller then calls Committed.
  absl::Status Append(SqliteDatabase& database,
                      std::span<const priors::SourceUpdate* const> updates);
  void Committed() { row_count_ = new_row_count_; }

  absl::StatusOr<uint32_t> LastSegment(const std::string& session_id);
  absl::StatusOr<std::vector<priors::AuditSegment>> List(const priors::AuditFilter& filter,
                                                         uint64_t after, uint32_t limit);
  absl::StatusOr<std::vector<std::string>> Load(uint64_t segment_id, uint64_t first_row,
                                                uint32_t limit, size_t max_bytes);

 private:
  explicit SqliteAuditLog(const priors::AuditLimits& limits) : limits_(limits) {}
  absl::Status Prepare(SqliteDatabase& database);
  absl::Status AppendAll(std::span<const priors::SourceUpdate* const> updates);
  absl::Status AppendOne(const std::string& session_id, const priors::AuditRows& rows);
  // Returns the segment's id, or 0 if the rows do not continue what is stored.
  absl::StatusOr<int64_t> Enter(const std::string& session_id, const priors::AuditRows& rows,
                                uint64_t count);
  absl::Status Trim();

  struct Statements {
    SqliteStatement session_rows, last_segment, add_segment, advance_segment, add_row,
        oldest_segment, delete_rows, delete_segment, list_segments, load_rows;
  };
  struct StatementText {
    SqliteStatement Statements::*statement;
    const char* sql;
  };
  static const StatementText kStatements[];

  priors::AuditLimits limits_;
  Statements statements_;
  uint64_t row_count_ = 0;      // rows of all stored segments
  uint64_t new_row_count_ = 0;  // the same once the current transaction is committed
};

}  // namespace sweepstake::storage
