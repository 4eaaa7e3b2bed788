// The interface through which a session reports its inputs and decisions, completely enough to
// derive every decision again. The audit log (engine_client/decider/audit) implements it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// An executed switch: the arguments of DecisionSession::ObserveSwitch.
struct SwitchReport {
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  int64_t now_ns = 0;
  SwitchCost cost;
};

// An order of an operator to the game. No decision depends on it, because the game reports a mode
// after it executes the order.
struct OrderReport {
  std::string_view operator_name;
  Mode mode = Mode::kManual;
  std::optional<uint32_t> arm;  // with kManual; absent: keep the active arm
  int64_t now_ns = 0;
};

// The inputs of a tick besides the active arm's run.
struct TickInput {
  int64_t now_ns = 0;
  std::span<const ShadowSample> shadow_samples;
  std::optional<SceneDescriptor> descriptor;
};

// Every event is reported before the session applies it. `runs` summarises the frames before the
// event. Calls come on the session's thread. An observer must not call the session back.
class DecisionObserver {
 public:
  virtual ~DecisionObserver() = default;

  virtual void OnSwitch(const SwitchReport& report, const ArmRuns& runs) = 0;
  virtual void OnRefusal(uint64_t command_id) = 0;
  virtual void OnMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs) = 0;
  virtual void OnOrder(const OrderReport& order) = 0;

  // OnDecision follows each of these two with the result.
  virtual void OnTick(const TickInput& input, const ArmRuns& runs) = 0;
  virtual void OnBailOut(const FrameSample& frame, int64_t now_ns, const ArmRuns& runs) = 0;
  virtual void OnDecision(const Decision& decision) = 0;
};

}  // namespace sweepstake::decision
