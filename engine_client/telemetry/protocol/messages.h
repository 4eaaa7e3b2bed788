// The messages that a client sends to and receives from sweepstake.v1.TelemetryService, as plain
// structs. telemetry.proto describes their fields. Where a struct of frame_sample.h or
// client_reports.h has the same content as a message, that struct is used.
//
// A received enumeration may have a value that only a newer protocol defines.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/client_reports.h"
#include "engine_client/math/beta_distribution.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

// Messages give intervals and limits in milliseconds, and measured times in nanoseconds.
inline constexpr uint64_t kNsPerMs = 1'000'000;

}  // namespace sweepstake

namespace sweepstake::protocol {

enum class Capability : uint32_t { kOperatorOrders = 1, kBoxView = 2, kStopsTrials = 3 };

struct Arm {
  std::string name;
  uint32_t backend_version = 0;
};

struct Hello {
  uint32_t protocol_version = 0;
  std::string project;
  std::string scene;
  std::string build;
  std::string machine_class;
  std::vector<Arm> arms;
  uint32_t active_arm = 0;
  Mode mode = Mode::kAi;
  std::string session_id;
  double time_scale = 0;
  bool ignore_priors = false;
  uint64_t seed = 0;
  std::string policy;
  uint32_t switch_epoch = 0;
  std::string resume_token;
  std::vector<Capability> capabilities;
  DecisionRules rules;
  uint32_t initial_arm = 0;
};

struct Goodbye {};

// Some of a frame's boxes. telemetry.proto describes the encoding of `boxes` and `pairs`.
struct BoxView {
  uint64_t frame_index = 0;
  uint32_t object_count = 0;
  uint32_t stride = 0;
  std::vector<float> bounds;
  std::string boxes;
  std::string pairs;
};

struct Welcome {
  std::string session_id;
  bool resumed = false;
  uint64_t acknowledged_sequence = 0;
  uint32_t max_batch_frames = 0;
  uint32_t max_message_bytes = 0;
  uint32_t batch_interval_ms = 0;
  uint32_t decision_interval_ms = 0;
  uint32_t settling_ms = 0;
  uint32_t bail_out_ms = 0;
  std::string daemon_version;
  std::string policy;
  uint64_t seed = 0;
  std::vector<decision::BetaPosterior> priors;
  uint64_t prior_source_count = 0;
  std::string resume_token;
  bool priors_unavailable = false;
  std::vector<Capability> capabilities;
  uint32_t cooldown_ms = 0;
  std::optional<RewardWeights> weights;
};

struct Acknowledgement {
  uint64_t sequence = 0;
  uint32_t batch_interval_ms = 0;
};

struct PosteriorSnapshot {
  std::vector<decision::BetaPosterior> arms;
  SceneVerdict verdict;
  std::vector<ArmStanding> standings;
  std::optional<double> saved_us;
};

struct Reconnect {
  uint32_t delay_ms = 0;
};

struct BoxRequest {
  uint32_t interval_ms = 0;
  uint32_t max_bytes = 0;
  uint32_t until_ms = 0;
};

// One response of the daemon. Each part may be absent.
struct Response {
  std::optional<Welcome> welcome;
  std::optional<SwitchCommand> switch_command;
  std::optional<Acknowledgement> acknowledgement;
  std::optional<PosteriorSnapshot> posterior_snapshot;
  std::optional<Reconnect> reconnect;
  std::optional<OperatorOrder> operator_order;
  std::optional<BoxRequest> box_request;
  bool has_unknown = false;  // has a field that this version does not define
};

}  // namespace sweepstake::protocol
