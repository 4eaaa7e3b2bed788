// A decision session and its game, on a scripted clock. Tests set the cost of the frames, and
// whether the game executes switches.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine_client/decider/session/decision_session.h"

namespace sweepstake::decision {

inline constexpr int64_t kSecond = 1'000'000'000;
inline constexpr int64_t kMillisecond = 1'000'000;

// Returns a setup with the arms "arm0", "arm1" …, the policy `paper` and no exploration.
SessionSetup PlainSetup(uint32_t arm_count);
// Returns PlainSetup(2) with priors that make the second arm clearly better.
SessionSetup SetupThatWantsArmOne();

class ScriptedClient {
 public:
  // The next frame, without index, arm and epoch, which the client fills in. By default it is
  // cheap, at 100 FPS.
  FrameSample frame{.frame_time_ns = 10'000'000,
                    .detection_time_ns = 1'667'000,
                    .aabb_check_count = 49'950,
                    .native_bytes = 16 << 20,
                    .object_count = 1'000};

  explicit ScriptedClient(const SessionSetup& setup);

  // Advances the clock by one frame and passes the frame to the session.
  void RunFrame();
  // Runs frames until the next tick is due, and then the tick. Stores its command, and executes the
  // command if `obedient`.
  Decision RunToTick();
  // Runs `count` ticks and returns the last decision.
  Decision RunTicks(int count);
  // Runs until the arm has settled and the window is empty, so that the next ticks learn.
  void Settle();
  // Executes a switch at once, as clients do: changes the epoch, then reports the switch.
  void Execute(uint32_t arm, SwitchReason reason);

  DecisionSession session;
  int64_t now_ns;
  uint32_t arm;
  uint32_t epoch;
  uint64_t frame_index = 0;  // of the next frame
  bool obedient = true;
  std::vector<Decision> log;
  std::vector<SwitchCommand> commands;
};

}  // namespace sweepstake::decision
