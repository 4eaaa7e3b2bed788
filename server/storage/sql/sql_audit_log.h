// The audit log in the prior store's database. It has a table of segments, a table of rows, whose
// ids grow in the order of arrival, and a table of chunks. A chunk is a range of row ids; the
// oldest chunk is removed as a whole. Rows of kAdminSession are in no chunk, and have a limit of
// their own. In a shared database, each daemon that writes applies its own limits. SqlPriorReader
// reads the log. Used by one thread at a time.
//
// Removed rows free space for new ones, but a file does not shrink.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/retention_clock.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

class SqlAuditLog {
 public:
  // `database` must outlive this object.
  SqlAuditLog(SqlDatabase& database, const priors::AuditLimits& limits)
      : database_(database), limits_(limits) {}

  // Changes the limits. Trim and Append remove rows beyond them.
  void Limit(const priors::AuditLimits& limits) { limits_ = limits; }
  // Removes rows beyond the limits, in the caller's transaction. `now_s` is the time of the
  // retention clock; 0 removes no rows because of their age.
  absl::Status Trim(uint64_t now_s);
  // Appends the rows of the updates in the caller's transaction. Returns how many could not be
  // written: invalid rows or, after an error, all rows. If no rows could be written, the
  // transaction is as it was before the call, or SQLite has ended it (disk full). Errors, only in a
  // shared database: UNAVAILABLE and ABORTED. After these the whole transaction must be repeated.
  absl::StatusOr<uint64_t> Append(std::span<const priors::SourceUpdate* const> updates);

 private:
  // A stored segment.
  struct Segment {
    int64_t id = 0;  // 0: there is no such segment
    uint64_t last_row = 0;
  };

  absl::Status AppendAll(std::span<const priors::SourceUpdate* const> updates, uint64_t& lost);
  absl::Status AppendOne(const priors::SourceUpdate& update, uint64_t now_s, uint64_t& lost);
  absl::StatusOr<Segment> Find(const std::string& session_id, uint32_t segment);
  // Adds `bytes` to the size of the latest chunk. Begins a new chunk if the latest one is full.
  absl::Status GrowChunk(uint64_t bytes, uint64_t now_s);
  // Returns the time of the retention clock, which begins at the time of the latest chunk.
  absl::StatusOr<uint64_t> RetentionTime(uint64_t unix_now_s);
  // Runs a statement that removes rows and returns their segments. Then removes the segments that
  // have no rows left.
  template <typename... Args>
  absl::Status RemoveRows(const char* sql, const Args&... args);

  SqlDatabase& database_;
  priors::AuditLimits limits_;
  std::optional<RetentionClock> clock_;  // absent before the first use
};

}  // namespace sweepstake::storage
