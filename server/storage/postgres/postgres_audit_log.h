// The audit log of a prior store in PostgreSQL, which all of its daemons write. The limits are
// those of the daemon that writes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/postgres/postgres_connection.h"

namespace sweepstake::storage {

class PostgresAuditLog {
 public:
  // `connection` must outlive it.
  PostgresAuditLog(PostgresConnection& connection, const priors::AuditLimits& limits)
      : connection_(connection), limits_(limits) {}

  // Writes the rows of updates in the running transaction, and removes the oldest rows until the
  // log is within its limits. Returns how many rows were lost. Rows that cannot be written leave
  // the transaction as it was. Errors: UNAVAILABLE and ABORTED, after which the whole transaction
  // must be repeated.
  absl::StatusOr<uint64_t> Append(std::span<const priors::SourceUpdate* const> updates);
  void Limit(const priors::AuditLimits& limits) { limits_ = limits; }
  // Removes the rows beyond the limits, in the running transaction.
  absl::Status Trim(uint64_t unix_now_s);

 private:
  struct Segment {
    int64_t id = 0;  // 0: missing
    uint64_t last_row = 0;
  };

  absl::Status AppendAll(std::span<const priors::SourceUpdate* const> updates, uint64_t& lost);
  absl::Status AppendOne(const priors::SourceUpdate& update, uint64_t& lost);
  absl::StatusOr<Segment> Find(const std::string& session_id, uint32_t segment);
  absl::StatusOr<int64_t> Add(const std::string& session_id, const priors::AuditRows& rows);
  // Adds the bytes to the latest chunk, or to a new one that begins with the next row.
  absl::Status GrowChunk(uint64_t bytes, uint64_t unix_now_s);
  absl::Status RemoveEmpty(const PostgresArray& segments);

  PostgresConnection& connection_;
  priors::AuditLimits limits_;
};

}  // namespace sweepstake::storage
