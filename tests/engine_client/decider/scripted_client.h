// A session with the game it decides for, on a scripted clock: frames of any cost, switches
// executed or not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine_client/decider/session/decision_session.h"

namespace sweepstake::decision {

inline constexpr int64_t kSecond = 1'000'000'000;
inline constexpr int64_t kMillisecond = 1'000'000;

// Names "arm0", "arm1" …, policy `paper`, no exploration.
SessionSetup PlainSetup(uint32_t arm_count);
// The same for two arms, of which the second is known to be the better one.
SessionSetup SetupThatWantsArmOne();

class ScriptedClient {
 public:
  // The cost of each frame, before the client fills in arm and epoch: 100 FPS, cheap.
  FrameSample frame{.frame_time_ns = 10'000'000,
                    .detection_time_ns = 1'667'000,
                    .aabb_check_count = 49'950,
                    .native_bytes = 16 << 20,
                    .object_count = 1'000};

  explicit ScriptedClient(const SessionSetup& setup);

  // One frame of the active arm: time passes, the session sees it.
  void RunFrame();
  // Frames until the tick is due, then the tick. A command is kept, and executed when `obedient`.
  Decision RunToTick();
  // The same for some ticks; the last decision.
  Decision RunTicks(int count);
  // Runs until the arm has settled and the window is empty: the next ticks learn.
  void Settle();
  // Executes a switch as clients do at once: epoch, then report.
  void Execute(uint32_t arm, SwitchReason reason);

  DecisionSession session;
  int64_t now_ns;
  uint32_t arm;
  uint32_t epoch;
  bool obedient = true;
  std::vector<Decision> log;
  std::vector<SwitchCommand> commands;
};

}  // namespace sweepstake::decision
