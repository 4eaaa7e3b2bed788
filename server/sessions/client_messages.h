// Messages from a client to its session, as plain values that have been checked. telemetry.proto
// explains the fields.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine_client/decider/client_reports.h"
#include "engine_client/decider/types.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

// The first message of a stream.
struct SessionRequest {
  priors::SceneKey scene;  // with the reward version of the policy
  std::vector<std::string> arms;
  std::vector<uint32_t> backend_versions;  // one per arm
  priors::SourceOrigin origin;
  bool is_of_player = false;  // stores evidence about known arms only
  std::string session_id;     // id of the session to resume; empty for a new one
  std::string resume_token;   // proves that the client owns the session
  std::string policy;         // never empty
  DecisionRules rules;        // before the time scale
  Mode mode = Mode::kManual;
  uint32_t active_arm = 0;
  uint32_t initial_arm = 0;
  uint32_t switch_epoch = 0;
  uint64_t seed = 0;  // 0: the daemon chooses one
  double time_scale = 1;
  bool ignores_priors = false;
  bool takes_orders = false;
  bool shows_boxes = false;
  bool stops_trials = false;  // bounds the cost of trials
};

// The result of a switch command, or a switch that the game made by itself.
struct SwitchAnswer {
  uint64_t command_id = 0;
  bool executed = false;
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  SwitchReason reason = {};
  decision::SwitchCost cost;
};

// A message of a newer protocol. It is counted and ignored.
struct UnknownMessage {};

// A message after Hello that changes the session.
struct Telemetry {
  uint64_t sequence = 0;  // counts from 1; a resent message keeps its number
  std::variant<UnknownMessage, protocol::FrameBatch, SwitchAnswer, protocol::BailOut, ModeChange,
               protocol::OrderRefusal>
      message;
};

}  // namespace sweepstake::sessions
