// Which arm runs in which switch epoch: the active run, and the one after it as soon as frames show
// it.
//
// Not thread-safe. Fixed memory: of several later epochs only the latest is kept.
#pragma once

#include <cstdint>
#include <optional>
#include <tuple>

#include "server/decision/arm_run.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

// Epochs wrap around; the later one is less than half of their range ahead.
bool IsLaterEpoch(uint32_t epoch, uint32_t than);

class ArmRuns {
 public:
  ArmRuns(uint32_t arm_count, ArmRun active) : arm_count_(arm_count), active_(active) {}

  // The run this frame belongs to. A frame of a later epoch than all before begins a later run,
  // which settles for `settling_ns`. Null: the frame is of an earlier epoch, or of an arm that does
  // not run in its epoch.
  ArmRun* Find(const Frame& frame, uint64_t settling_ns);

  ArmRun& active() { return active_; }
  const ArmRun& active() const { return active_; }
  // A run that frames have shown and that is not active yet.
  const std::optional<ArmRun>& later() const { return later_; }
  bool IsActive(const Frame& frame) const;

  // From here on `run` is the active one; there is no later one.
  void Activate(const ArmRun& run);

  // Begins the window of the next tick.
  void ClearWindow();
  // Whether the running tick has seen frames of the active run, measured or left out.
  bool active_frames_seen() const { return active_frames_seen_; }

  // References to every member of ArmRuns or const ArmRuns but the number of arms, for the audit
  // log.
  template <typename Self>
  static auto Fields(Self& runs) {
    auto& [arm_count, active, later, active_frames_seen] = runs;
    return std::tie(active, later, active_frames_seen);
  }

 private:
  uint32_t arm_count_;
  ArmRun active_;
  std::optional<ArmRun> later_;
  bool active_frames_seen_ = false;
};

}  // namespace sweepstake::decision
