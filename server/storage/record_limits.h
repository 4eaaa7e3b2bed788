// The limits of every store, checked before anything is written.
#pragma once

#include <span>
#include <string>

#include "absl/status/status.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

inline constexpr double kMaxEvidence = 1e15;  // exclusive maximum of an increment and of a sum
// The maximum of sequences and counts, which must fit SQLite's integers.
inline constexpr uint64_t kMaxCount = (1ull << 63) - 1;

// Check all updates or records. The error INVALID_ARGUMENT names the invalid one (from 0) and its
// field.
absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates);
absl::Status CheckRecords(std::span<const priors::PriorRecord> records);

// Error: RESOURCE_EXHAUSTED (`count` is above `max_records`).
absl::Status QuarantineBound(uint64_t count, uint64_t max_records);

// Returns whether a revocation bars a source that is not in the store: only if it names an id and
// nothing else. Otherwise the store may have the source with another project, build or time.
bool BarsUnknown(const priors::SourceFilter& filter);

// Returns whether the row can be stored. None can if a name in `rows` is invalid.
bool IsStorable(const priors::AuditRows& rows, const priors::AuditRow& row);

// Audit rows that were stored from `unix_start_s` on.
struct AuditChunk {
  uint64_t unix_start_s = 0;
  uint64_t byte_count = 0;  // of the rows' text
};
// Returns whether the chunk is full: it holds a 32nd of the log's limits.
bool IsFull(const AuditChunk& chunk, const priors::AuditLimits& limits, uint64_t unix_now_s);
// Returns whether the oldest chunk must be removed from a log of `log_bytes`.
bool IsBeyond(const AuditChunk& oldest, uint64_t log_bytes, const priors::AuditLimits& limits,
              uint64_t unix_now_s);

}  // namespace sweepstake::storage
