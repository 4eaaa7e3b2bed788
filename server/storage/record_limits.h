// The bounds every store puts on what it keeps, checked before anything is written.
#pragma once

#include <span>

#include "absl/status/status.h"
#include "server/priors/prior_store.h"

namespace sweepstake::storage {

inline constexpr double kMaxEvidence = 1e15;  // exclusive; of an increment and of a sum
inline constexpr uint64_t kMaxCount =
    (1ull << 63) - 1;  // sequences and counts fit SQLite's integers
inline constexpr size_t kMaxNameBytes = 128;

// INVALID_ARGUMENT names the update or record (from 0) and the field.
absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates);
absl::Status CheckRecords(std::span<const priors::PriorRecord> records);

// How many more rows of a session's audit log may be stored.
uint64_t AuditRoom(const priors::AuditLimits& limits, uint64_t stored_row_count);
// How many of the rows, from the first on, are fit to be stored: at most `room`, up to the first
// one that is too long; 0 where the names are.
size_t StorableAuditRows(const priors::AuditRows& rows, uint64_t room);

}  // namespace sweepstake::storage
