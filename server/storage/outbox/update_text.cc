#include "server/storage/outbox/update_text.h"

#include <nlohmann/json.hpp>

namespace sweepstake {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(EvidenceKey, project, scene, measured_by, arm, backend_version,
                                   machine_class, reward_version)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Evidence, alpha, beta, window_count, bail_out_count)

}  // namespace sweepstake

namespace sweepstake::priors {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KeyedEvidence, key, evidence)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceProgress, source_id, commit_sequence, message_sequence,
                                   explored_arm_count, decision_count, frame_count, seed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AuditRow, number, bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AuditRows, segment, project, scene, unix_start_ms, rows)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceOrigin, build, token_id)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceWriter, id, resumed_sequence)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceUpdate, progress, unix_time_s, increments, audit, origin,
                                   writer)

}  // namespace sweepstake::priors

namespace sweepstake::storage {

using nlohmann::json;

std::string UpdateText(const priors::SourceUpdate& update) {
  const auto bytes = json::to_cbor(json(update));
  return {bytes.begin(), bytes.end()};
}

absl::StatusOr<priors::SourceUpdate> UpdateIn(const std::string& text) {
  try {
    return json::from_cbor(text).get<priors::SourceUpdate>();
  } catch (const json::exception& error) {
    return absl::DataLossError(error.what());
  }
}

}  // namespace sweepstake::storage
