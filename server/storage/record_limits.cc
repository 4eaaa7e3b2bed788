#include "server/storage/record_limits.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/text/names.h"

namespace sweepstake::storage {
namespace {

using priors::Evidence;
using priors::EvidenceKey;
using text::IsName;
using text::IsOptionalName;

// Returns a description of the invalid number, or an empty text. NaN fails these comparisons.
absl::string_view WrongEvidence(const Evidence& evidence) {
  if (!(evidence.alpha >= 0 && evidence.alpha < kMaxEvidence))
    return "alpha must be finite, 0 to 1e15";
  if (!(evidence.beta >= 0 && evidence.beta < kMaxEvidence))
    return "beta must be finite, 0 to 1e15";
  if (evidence.window_count > kMaxCount) return "window_count must be below 2^63";
  if (evidence.bail_out_count > kMaxCount) return "bail_out_count must be below 2^63";
  return {};
}

absl::string_view WrongKey(const EvidenceKey& key) {
  if (!IsName(key.project)) return "project must be a name of 1 to 128 bytes";
  if (!IsName(key.scene)) return "scene must be a name of 1 to 128 bytes";
  if (!IsName(key.arm)) return "arm must be a name of 1 to 128 bytes";
  if (!decision::IsMeasuredBy(key.measured_by)) return "measured_by must be absent or \"lane\"";
  if (!IsOptionalName(key.machine_class)) return "machine_class must be absent or a name";
  if (key.backend_version == 0) return "backend_version must be at least 1";
  if (key.reward_version == 0) return "reward_version must be at least 1";
  if (!decision::MiddleOf(key.regime)) return "regime must be absent or numbers such as 13/-4/0";
  return {};
}

absl::string_view WrongSource(const std::string& source_id, uint64_t sequence) {
  if (!IsName(source_id)) return "source_id must be a name of 1 to 128 bytes";
  if (sequence == 0 || sequence > kMaxCount) return "the source's sequence must be 1 to 2^63 - 1";
  return {};
}

absl::string_view WrongUpdate(const priors::SourceUpdate& update) {
  const auto& progress = update.progress;
  absl::string_view wrong = WrongSource(progress.source_id, progress.commit_sequence);
  if (wrong.empty() && progress.message_sequence > kMaxCount)
    wrong = "message_sequence must be below 2^63";
  if (wrong.empty() && progress.decision_count > kMaxCount)
    wrong = "decision_count must be below 2^63";
  if (wrong.empty() && progress.frame_count > kMaxCount) wrong = "frame_count must be below 2^63";
  if (wrong.empty() && update.unix_time_s > kMaxCount) wrong = "unix_time_s must be below 2^63";
  if (wrong.empty() && !IsOptionalName(update.origin.build))
    wrong = "build must be absent or a name";
  if (wrong.empty() && update.origin.token_id < 0) wrong = "token_id must not be negative";
  if (wrong.empty() && update.origin.player.size() > kMaxPartyBytes) wrong = "player is too long";
  if (wrong.empty() && update.origin.network.size() > kMaxPartyBytes) wrong = "network is too long";
  for (const auto& increment : update.increments) {
    if (wrong.empty()) wrong = WrongKey(increment.key);
    if (wrong.empty()) wrong = WrongEvidence(increment.evidence);
  }
  return wrong;
}

absl::string_view WrongRecord(const priors::PriorRecord& record) {
  absl::string_view wrong = WrongKey(record.key);
  if (wrong.empty()) wrong = WrongSource(record.source_id, record.source_sequence);
  if (wrong.empty() && !IsOptionalName(record.build)) wrong = "build must be absent or a name";
  if (wrong.empty() && record.last_seen_unix_s > kMaxCount)
    wrong = "unix_last_seen_s must be below 2^63";
  if (wrong.empty()) wrong = WrongEvidence(record.evidence);
  return wrong;
}

constexpr uint64_t kAuditChunks = 32;

// Returns the chunk's age in seconds; 0 if the wall clock was set back.
uint64_t AgeS(const AuditChunk& chunk, uint64_t unix_now_s) {
  return unix_now_s > chunk.unix_start_s ? unix_now_s - chunk.unix_start_s : 0;
}

}  // namespace

absl::Status CheckUpdates(std::span<const priors::SourceUpdate> updates) {
  for (size_t i = 0; i < updates.size(); ++i) {
    const absl::string_view wrong = WrongUpdate(updates[i]);
    if (!wrong.empty()) return absl::InvalidArgumentError(absl::StrCat("update ", i, ": ", wrong));
  }
  return absl::OkStatus();
}

absl::Status CheckRecords(std::span<const priors::PriorRecord> records) {
  for (size_t i = 0; i < records.size(); ++i) {
    const absl::string_view wrong = WrongRecord(records[i]);
    if (!wrong.empty()) return absl::InvalidArgumentError(absl::StrCat("record ", i, ": ", wrong));
  }
  return absl::OkStatus();
}

absl::Status QuarantineBound(uint64_t count, uint64_t max_records) {
  if (count <= max_records) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("this import would raise the number of records in quarantine to ", count,
                   ", but at most ", max_records, " are allowed; promote or revoke some first"));
}

bool BarsUnknown(const priors::SourceFilter& filter) {
  return !filter.id.empty() && filter.id != decision::kAdminSession &&
         filter == priors::SourceFilter{.id = filter.id};
}

bool IsStorable(const priors::AuditRows& rows, const priors::StoredAuditRow& row) {
  return IsName(rows.project) && IsName(rows.scene) && rows.segment > 0 && row.number > 0 &&
         row.number <= kMaxCount && !row.bytes.empty() &&
         row.bytes.size() <= priors::kMaxAuditRowBytes;
}

bool IsFull(const AuditChunk& chunk, const priors::AuditLimits& limits, uint64_t unix_now_s) {
  return chunk.byte_count >= limits.bytes / kAuditChunks ||
         AgeS(chunk, unix_now_s) > limits.age_s / kAuditChunks;
}

bool IsBeyond(const AuditChunk& oldest, uint64_t log_bytes, const priors::AuditLimits& limits,
              uint64_t unix_now_s) {
  return log_bytes > limits.bytes || AgeS(oldest, unix_now_s) > limits.age_s;
}

}  // namespace sweepstake::storage
