// Writes the notes in a flight recorder's file. Frames are arrays of numbers without field names,
// which keeps the notes short for thousands of frames.
#include <nlohmann/json.hpp>

#include "engine_client/decider/types.h"
#include "engine_client/telemetry/common/flight_recorder.h"

namespace sweepstake {
namespace {

using Json = nlohmann::ordered_json;

// The columns of a frame's array. `boxes` is the index of the frame's boxes among all boxes in the
// file, or null if its boxes were not recorded.
constexpr const char* kColumns[] = {"frame",        "frame_ns", "detection_ns", "objects",
                                    "pairs",        "checks",   "native_bytes", "arm",
                                    "switch_epoch", "flags",    "boxes"};

Json FrameRow(const FlightFrame& frame, Json boxes) {
  const FrameSample& sample = frame.sample;
  return {sample.frame_index,  sample.frame_time_ns, sample.detection_time_ns,
          sample.object_count, sample.pair_count,    sample.aabb_check_count,
          sample.native_bytes, sample.arm,           sample.switch_epoch,
          sample.flags,        std::move(boxes)};
}

Json FrameRows(const std::vector<FlightFrame>& frames) {
  Json rows = Json::array();
  size_t box_frame = 0;
  for (const FlightFrame& frame : frames)
    rows.push_back(FrameRow(frame, frame.box_count == 0 ? Json() : Json(box_frame++)));
  return rows;
}

Json DecisionOf(const FlightDecision& seen) {
  const LastDecision& decision = seen.decision;
  Json document = {{"frame", seen.frame_index},
                   {"decision", decision.decision_id},
                   {"outcome", decision::NameOf(decision::kOutcomeNames, decision.outcome)},
                   {"active_arm", decision.active_arm}};
  document["candidate_arm"] = decision.candidate_arm ? Json(*decision.candidate_arm) : Json();
  document["commanded_arm"] = decision.command ? Json(decision.command->arm) : Json();
  if (decision.command) {
    document["reason"] = decision::NameOf(decision::kSwitchReasonNames, decision.command->reason);
  }
  document["verdict"] = decision::NameOf(decision::kVerdictNames, decision.verdict.verdict);
  document["best_probability"] = Json::array();
  for (uint64_t arm = 0; arm < decision.arm_count; ++arm)
    document["best_probability"].push_back(decision.best_probability[arm]);
  return document;
}

}  // namespace

std::string FlightNotes(const SessionOptions& options, const AdaptiveBroadPhase& adaptive,
                        const std::vector<FlightFrame>& frames, size_t worst,
                        const std::deque<FlightDecision>& decisions, int64_t recorded_unix_ms) {
  Json document = {{"flight_recording", 1},
                   {"project", options.project},
                   {"scene", options.scene},
                   {"build", options.build},
                   {"machine_class", options.machine_class},
                   {"recorded_unix_ms", recorded_unix_ms},
                   {"frame_budget_ms", options.flight_recorder.frame_budget_ms},
                   {"worst_frame", frames[worst].sample.frame_index},
                   {"arms", adaptive.arms()},
                   {"frame_columns", kColumns},
                   {"frames", FrameRows(frames)}};
  document["decisions"] = Json::array();
  for (const FlightDecision& seen : decisions) {
    if (seen.frame_index >= frames.front().sample.frame_index)
      document["decisions"].push_back(DecisionOf(seen));
  }
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sweepstake
