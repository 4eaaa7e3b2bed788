// The interface through which a session reports its inputs and decisions. The reports are complete:
// every decision can be derived from them again. The audit log (engine_client/decider/audit)
// implements it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// An executed switch, with the arguments of DecisionSession::ObserveSwitch.
struct SwitchReport {
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  int64_t now_ns = 0;
  SwitchCost cost;
};

// An operator's order to the game. Decisions do not depend on it: when the game has executed the
// order, it reports its new mode.
struct OrderReport {
  std::string_view operator_name;
  Mode mode = Mode::kManual;
  std::optional<uint32_t> arm;  // only with kManual; absent: keep the active arm
  int64_t now_ns = 0;
};

// The inputs of a tick, except the arms' runs (arm_runs.h).
struct TickInput {
  int64_t now_ns = 0;
  std::span<const ShadowSample> shadow_samples;
  std::optional<SceneDescriptor> descriptor;
};

// Receives every event before the session applies it. `runs` summarises the frames before the
// event. All calls come on the session's thread. An observer must not call the session.
class DecisionObserver {
 public:
  virtual ~DecisionObserver() = default;

  virtual void OnSwitch(const SwitchReport& report, const ArmRuns& runs) = 0;
  virtual void OnRefusal(uint64_t command_id) = 0;
  virtual void OnMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs) = 0;
  virtual void OnOrder(const OrderReport& order) = 0;

  // The session calls OnDecision with the result after each of these two.
  virtual void OnTick(const TickInput& input, const ArmRuns& runs) = 0;
  virtual void OnBailOut(const FrameSample& frame, int64_t now_ns, const ArmRuns& runs) = 0;
  virtual void OnDecision(const Decision& decision) = 0;
};

}  // namespace sweepstake::decision
