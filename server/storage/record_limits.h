// The limits of every store. They are checked before anything is written.
#pragma once

#include <span>
#include <string>

#include "absl/status/status.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

inline constexpr double kMaxEvidence = 1e15;  // exclusive maximum of an increment and of a sum
// The maximum of sequences and counts, which must fit SQLite's integers.
inline constexpr uint64_t kMaxCount = (1ull << 63) - 1;

// These check all updates or records. The error INVALID_ARGUMENT names the one (from 0) and the
// field.
absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates);
absl::Status CheckRecords(std::span<const priors::PriorRecord> records);

// Error: RESOURCE_EXHAUSTED (so many records in quarantine are more than may wait there).
absl::Status QuarantineBound(uint64_t count, uint64_t max_records);

// Returns whether a revocation bars a source that the store has nothing of: one that asks for its
// id alone. With more than that, the store may have it, of another project, build or time.
bool BarsUnknown(const priors::SourceFilter& filter);

// Returns whether one of the rows can be stored. If a name of theirs is invalid, none can be.
bool IsStorable(const priors::AuditRows& rows, const priors::AuditRow& row);

// Audit rows that were stored in the seconds from `unix_start_s` on.
struct AuditChunk {
  uint64_t unix_start_s = 0;
  uint64_t byte_count = 0;  // of the rows' text
};
// Returns whether the chunk takes no more rows, because it holds a 32nd of what the log may.
bool IsFull(const AuditChunk& chunk, const priors::AuditLimits& limits, uint64_t unix_now_s);
// Returns whether the oldest chunk of a log of so many bytes is to be removed.
bool IsBeyond(const AuditChunk& oldest, uint64_t log_bytes, const priors::AuditLimits& limits,
              uint64_t unix_now_s);

}  // namespace sweepstake::storage
