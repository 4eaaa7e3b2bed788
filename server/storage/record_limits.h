// Limits of the values in every prior store. They are checked before anything is written.
#pragma once

#include <span>
#include <string>

#include "absl/status/status.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::storage {

inline constexpr double kMaxEvidence = 1e15;  // exclusive maximum of an increment and of a sum
// The maximum of sequences and counts, which must fit SQLite's integers.
inline constexpr uint64_t kMaxCount = (1ull << 63) - 1;
inline constexpr size_t kMaxPartyBytes = 64;  // of a player or a network

// Check all updates or records. The error INVALID_ARGUMENT contains the index (from 0) of the first
// invalid one, and its field.
absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates);
absl::Status CheckRecords(std::span<const priors::PriorRecord> records);

// Checks the number of records that would be in quarantine. Error: RESOURCE_EXHAUSTED (`count` is
// above `max_records`).
absl::Status QuarantineBound(uint64_t count, uint64_t max_records);

// Returns whether a revocation that matches no stored source also bars the unknown source with the
// filter's id. It does only if the filter consists of an id alone. With further conditions, the
// store may have that source, but with another project, build or time.
bool BarsUnknown(const priors::SourceFilter& filter);

// Returns whether the row can be stored. If a name in `rows` is invalid, no row can be stored.
bool IsStorable(const priors::AuditRows& rows, const priors::StoredAuditRow& row);

// A range of rows of the audit log, which is removed as a whole. Its first row was stored at
// `unix_start_s`.
struct AuditChunk {
  uint64_t unix_start_s = 0;
  uint64_t byte_count = 0;  // of the rows' text
};
// Returns whether the chunk is full: it has 1/32 of the log's maximum bytes, or is older than 1/32
// of the log's maximum age.
bool IsFull(const AuditChunk& chunk, const priors::AuditLimits& limits, uint64_t unix_now_s);
// Returns whether the oldest chunk must be removed, because the log's size `log_bytes` is above the
// limit or the chunk is too old.
bool IsBeyond(const AuditChunk& oldest, uint64_t log_bytes, const priors::AuditLimits& limits,
              uint64_t unix_now_s);

}  // namespace sweepstake::storage
