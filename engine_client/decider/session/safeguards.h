// The rules that limit switching (paper §4, §6.3): which long frames are blamed on the arm, which
// of those are evidence, the cooldown with at most one command at a time, whether the scene as a
// whole is too slow, and when its verdict changes.
//
// Plain values; not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Returns whether the frame is over the limit, by its time or by the client's judgement
// (kFrameBailOut).
bool IsOverBailOutLimit(const FrameSample& frame, int64_t bail_out_ns);

// Returns whether the arm is to blame for such a frame. It is not to blame while paused or loading,
// nor if detection takes less than half of the frame. The paper has no such excuse: this function
// is not called for a policy whose kind has blames_any_cause (policy.h).
bool BlamesArm(const FrameSample& frame, int64_t bail_out_ns);

// Decides which bail-outs become evidence for other sessions. A frame over the limit takes longer
// than the limit, so a game cannot have more than one in that time. A client that reports more is
// wrong or lies. kBurst at once are accepted, because a client that reconnects reports what
// happened meanwhile.
class BailOutBudget {
 public:
  static constexpr int64_t kBurst = 16;

  // REQUIRES: 0 < bail_out_ns <= kMaxIntervalNs.
  BailOutBudget(int64_t bail_out_ns, int64_t start_ns)
      : bail_out_ns_(bail_out_ns), spent_until_ns_(start_ns) {}

  // Returns whether a bail-out at this time is evidence.
  bool HasRoom(int64_t now_ns) const;
  // As HasRoom. If the bail-out is evidence, it also spends a part of the budget.
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

  // The time allowed for a command to reach the client and for its first frame to come back: two of
  // the paper's decision intervals. A time scale does not shorten it, because it does not shorten
  // the network.
  static constexpr int64_t kCommandPatienceNs = 4'000'000'000;

  // A command is under way from the moment it is issued until a switch is executed, the client
  // refuses it, or it counts as lost. It is lost at the second or a later tick after it, once
  // kCommandPatienceNs have passed, if the interval of that tick brought frames of the old epoch
  // and none of a later one. The next candidate that differs is then commanded again.
  void OnCommand(int64_t now_ns);
  void OnExecuted(int64_t executed_ns);
  void OnRefused() { ticks_since_command_.reset(); }
  void OnTick(bool old_epoch_frames_seen, int64_t now_ns);
  bool switch_under_way() const { return ticks_since_command_.has_value(); }

 private:
  std::optional<int64_t> last_switch_ns_;
  std::optional<uint32_t> ticks_since_command_;
  int64_t commanded_ns_ = 0;  // only valid while ticks_since_command_ is present
};

// Decides whether a scene is degraded: even the arm that is most probably the best misses the
// frame-rate floor (paper §7.1).
//
// To avoid flicker, kWindowCount windows in a row are needed to enter the state, and the same
// number to leave it. A window of any arm under the floor counts towards entering only while the
// leader's own latest window was under the floor too. If the leader was fast when it ran, or never
// ran, a slow window of another arm shows nothing. A window at or above the floor counts towards
// leaving. At the paper's interval three windows are 6 s.
class FrameRateFloor {
 public:
  static constexpr uint32_t kWindowCount = 3;

  // A floor of 0 switches it off.
  FrameRateFloor(double floor_fps, uint32_t arm_count)
      : floor_fps_(floor_fps), missed_(arm_count) {}

  // Takes a window of `arm`. A bail-out charged to the arm counts as a window of 0 FPS, because its
  // frames are in no window. REQUIRES: arm, leader < arm_count.
  void Observe(uint32_t arm, double fps, uint32_t leader);
  bool degraded() const { return degraded_; }

 private:
  double floor_fps_;
  std::vector<bool> missed_;  // whether each arm's latest window was under the floor
  bool degraded_ = false;
  uint32_t contrary_count_ = 0;  // successive windows that contradict the current state
};

// Holds a verdict until another one was observed kTickCount times in a row, so that a game that
// acts on it does not flicker. At the paper's interval that is 6 s. The first verdict is shown at
// once.
class SteadyVerdict {
 public:
  static constexpr uint32_t kTickCount = 3;

  // Returns the verdict to show. kUnknown stands for no verdict and is shown at once.
  Verdict Observe(Verdict verdict);

 private:
  Verdict shown_ = Verdict::kUnknown;
  Verdict latest_ = Verdict::kUnknown;
  uint32_t latest_count_ = 0;  // successive observations of the latest verdict
};

}  // namespace sweepstake::decision
