// The audit log in the prior store's SQLite file. It has a table of segments, a table of rows,
// whose ids grow in the order of arrival, and a table of chunks, each a range of those ids. The
// oldest chunk is removed as a whole. Rows of kAdminSession are in no chunk, and have a limit of
// their own. Used by one thread at a time; the database must outlive it.
//
// Removed rows free space for new ones, but the file does not shrink.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Reads the log.
class SqliteAuditReader {
 public:
  static absl::StatusOr<SqliteAuditReader> Open(SqliteDatabase& database);

  absl::StatusOr<uint32_t> LastSegment(const std::string& session_id);
  absl::StatusOr<std::vector<priors::AuditSegment>> List(const priors::AuditFilter& filter,
                                                         uint64_t after, uint32_t limit);
  absl::StatusOr<std::vector<priors::AuditRow>> Load(uint64_t segment_id, uint64_t first_row,
                                                     uint32_t limit, size_t max_bytes);

 private:
  SqliteStatement last_segment_, list_segments_, load_rows_;
};

class SqliteAuditLog {
 public:
  static absl::StatusOr<SqliteAuditLog> Open(SqliteDatabase& database,
                                             const priors::AuditLimits& limits);

  // Changes the limits. Trim and Append remove rows beyond them.
  void Limit(const priors::AuditLimits& limits) { limits_ = limits; }
  // Removes rows beyond the limits, in the caller's transaction.
  absl::Status Trim(uint64_t unix_now_s);

  // Appends the rows of the updates in the caller's transaction. Returns how many could not be
  // written: invalid rows or, after an error, all rows. After an error the transaction is as
  // before, or SQLite has ended it.
  uint64_t Append(SqliteDatabase& database, std::span<const priors::SourceUpdate* const> updates);

 private:
  // A stored segment.
  struct Segment {
    int64_t id = 0;
    uint64_t last_row = 0;
  };

  explicit SqliteAuditLog(const priors::AuditLimits& limits) : limits_(limits) {}
  absl::Status Prepare(SqliteDatabase& database);
  absl::Status AppendAll(std::span<const priors::SourceUpdate* const> updates, uint64_t& lost);
  absl::Status AppendOne(const priors::SourceUpdate& update, uint64_t& lost);
  // Returns a segment with id 0 if it is missing.
  absl::StatusOr<Segment> Find(const std::string& session_id, uint32_t segment);
  absl::StatusOr<int64_t> Add(const std::string& session_id, const priors::AuditRows& rows);
  // Adds to the bytes of the latest chunk, or of a new one if that is full.
  absl::Status GrowChunk(uint64_t bytes, uint64_t unix_now_s);
  absl::Status TrimAdmin();
  absl::Status RemoveChunk(int64_t first_row_id);
  // Runs a statement that removes rows and returns their segments. Removes the segments that are
  // empty then.
  template <typename... Args>
  absl::Status RemoveRows(SqliteStatement& statement, const Args&... args);

  struct Statements {
    SqliteStatement find_segment, add_segment, add_row, latest_chunk, add_chunk, grow_chunk,
        oldest_chunk, delete_rows, delete_admin_rows, delete_chunk, delete_empty_segment;
  };
  struct StatementText {
    SqliteStatement Statements::*statement;
    const char* sql;
  };
  static const StatementText kStatements[];

  priors::AuditLimits limits_;
  Statements statements_;
};

}  // namespace sweepstake::storage
