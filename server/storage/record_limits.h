// The limits of every store. They are checked before anything is written.
#pragma once

#include <span>

#include "absl/status/status.h"
#include "server/priors/prior_store.h"

namespace sweepstake::storage {

inline constexpr double kMaxEvidence = 1e15;  // exclusive maximum of an increment and of a sum
// The maximum of sequences and counts, which must fit SQLite's integers.
inline constexpr uint64_t kMaxCount = (1ull << 63) - 1;

// These check all updates or records. The error INVALID_ARGUMENT names the update or record (from
// 0) and the field.
absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates);
absl::Status CheckRecords(std::span<const priors::PriorRecord> records);

// Returns how many more rows of a session's audit log may be stored.
uint64_t AuditRoom(const priors::AuditLimits& limits, uint64_t stored_row_count);
// Returns how many of the rows, from the first one on, can be stored: at most `room`, and those
// before the first row that is empty or too long. If a name is invalid, none can be.
size_t StorableAuditRows(const priors::AuditRows& rows, uint64_t room);

}  // namespace sweepstake::storage
