// The rules that limit switching (paper §4, §6.3):
// - which long frames are blamed on the arm (IsCausedByArm), and which of these frames become
// evidence
//   (BailOutBudget)
// - the cooldown, and at most one command at a time (SwitchGate)
// - when the broad phase makes the scene too slow (FrameRateFloor), and when its verdict changes
//   (SteadyVerdict)
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Returns whether the frame is over the bail-out limit: it is longer than `bail_out_ns`, or the
// client flagged it (kFrameBailOut). A suspended frame is not, because its time was not computed.
bool IsOverBailOutLimit(const FrameSample& frame, int64_t bail_out_ns);

// Returns whether the frame is over the bail-out limit because of its arm (IsCausedByDetection).
// The paper blames any cause: policies with counts_any_cause (policy.h) do not use this function.
bool IsCausedByArm(const FrameSample& frame, int64_t bail_out_ns);

// Decides which bail-outs become evidence for other sessions. Each of them takes longer than the
// limit bail_out_ns, so a game can have at most one per bail_out_ns. A client that reports more
// sends false data. Up to kBurst may arrive at once, because a client that reconnects reports what
// happened while it was disconnected.
class BailOutBudget {
 public:
  static constexpr int64_t kBurst = 16;

  // REQUIRES: 0 < bail_out_ns <= kMaxIntervalNs.
  BailOutBudget(int64_t bail_out_ns, int64_t start_ns)
      : bail_out_ns_(bail_out_ns), spent_until_ns_(start_ns) {}

  // Returns whether a bail-out at this time is evidence.
  bool HasRoom(int64_t now_ns) const;
  // Returns HasRoom(now_ns). If true, also counts the bail-out against the budget.
  bool Spend(int64_t now_ns);

 private:
  int64_t bail_out_ns_;
  int64_t spent_until_ns_;  // time at which the budget is full again
};

// Decides whether a switch may be commanded now.
class SwitchGate {
 public:
  // If `last_switch_ns` is absent, there was no switch yet and no cooldown runs.
  explicit SwitchGate(std::optional<int64_t> last_switch_ns) : last_switch_ns_(last_switch_ns) {}

  bool CooldownPassed(int64_t now_ns, int64_t cooldown_ns) const;
  std::optional<int64_t> last_switch_ns() const { return last_switch_ns_; }

  // Time for a command to reach the client and for its first frame to come back: two of the paper's
  // decision intervals. A time scale does not shorten it, because the network does not become
  // faster.
  static constexpr int64_t kCommandPatienceNs = 4'000'000'000;

  // A command is under way from its issue until one of these:
  // - a switch is executed
  // - the client refuses the command
  // - the command counts as lost: at the second or a later tick after it, when kCommandPatienceNs
  //   have passed, and the latest interval brought frames of the old epoch but none of a later one
  // After a loss, the next candidate other than the active arm is commanded.
  void OnCommand(int64_t now_ns);
  void OnExecuted(int64_t executed_ns);
  void OnRefused() { ticks_since_command_.reset(); }
  void OnTick(bool old_epoch_frames_seen, int64_t now_ns);
  bool switch_under_way() const { return ticks_since_command_.has_value(); }

 private:
  std::optional<int64_t> last_switch_ns_;
  std::optional<uint32_t> ticks_since_command_;
  int64_t commanded_ns_ = 0;  // meaningful only if ticks_since_command_ is present
};

// Decides whether a scene is degraded: even with the leader, the arm that is most probably the
// best, the broad phase makes the game miss the frame-rate floor (paper §7.1).
//
// A window misses the floor if its frame rate is below the floor and the broad phase is to blame:
// - without the detection time, the game would reach the floor, or
// - detection takes at least half of the frame, the limit of IsCausedByDetection.
// So a game that is capped at 12 FPS, or that is slow because of its rendering, does not miss it.
//
// So that the state does not alternate, it changes only after kWindowCount windows in a row (6 s at
// the paper's interval).
// - A window that misses the floor, of any arm, counts towards entering the state if the leader's
//   own latest window missed it too. Otherwise the leader was fast or has not run, so the slow
//   window of another arm shows nothing.
// - Any other window counts towards leaving the state.
class FrameRateFloor {
 public:
  static constexpr uint32_t kWindowCount = 3;

  // A floor of 0 FPS means that no scene is degraded.
  FrameRateFloor(double floor_fps, uint32_t arm_count)
      : floor_fps_(floor_fps), missed_(arm_count) {}

  // The mean times of a window per frame.
  struct Times {
    double frame_ms = 0;
    double detection_ms = 0;
  };
  // Observes a window of `arm`. A bail-out charged to the arm counts as a window of one frame,
  // because frames over the limit are in no window. REQUIRES: arm, leader < arm_count.
  void Observe(uint32_t arm, const Times& window, uint32_t leader);
  bool degraded() const { return degraded_; }

 private:
  bool IsMissedIn(const Times& window) const;

  double floor_fps_;
  std::vector<bool> missed_;  // whether each arm's latest window missed the floor
  bool degraded_ = false;
  uint32_t contrary_count_ = 0;  // windows in a row that contradict the current state
};

// Shows a verdict until another one was observed kTickCount times in a row (6 s at the paper's
// interval), so that a game that reacts to it does not flicker. The first verdict is shown at once.
class SteadyVerdict {
 public:
  static constexpr uint32_t kTickCount = 3;

  // Returns the verdict to show. kUnknown means that there is no verdict, and is shown at once.
  Verdict Observe(Verdict verdict);

 private:
  Verdict shown_ = Verdict::kUnknown;
  Verdict latest_ = Verdict::kUnknown;
  uint32_t latest_count_ = 0;  // observations of `latest_` in a row
};

}  // namespace sweepstake::decision
