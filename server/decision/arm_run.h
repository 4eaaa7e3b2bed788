// The frames of one arm in one switch epoch: which of them settle, which are measured, and the
// window of the latter.
//
// Time here is the frames' own: it runs from the end of the run's first frame and is the sum of the
// frame times after it. The first frame, which builds the structure, always belongs to the settling
// (unless that is 0 long).
#pragma once

#include <cstdint>
#include <tuple>

#include "server/decision/types.h"
#include "server/decision/window.h"

namespace sweepstake::decision {

class ArmRun {
 public:
  // Frames that begin before `settling_ns` of the run has passed are settling frames.
  ArmRun(uint32_t arm, uint32_t switch_epoch, uint64_t settling_ns);

  // A frame of this run; true: it was measured, false: it settles.
  //
  // `rebuild_settling_ns` > 0: a rebuild (changed object count) of a measured run settles again for
  // that long, the window keeping what it has. So that counts which change all the time do not
  // starve learning, this happens only when at least as much frame time has been measured since the
  // last settling: at most half of the time is settling.
  bool Observe(const Frame& frame, uint64_t rebuild_settling_ns);
  // A frame whose time passes without being measured: it was over the bail-out limit.
  void Pass(const Frame& frame);

  // Settles anew from the next frame on, as if the run began with it.
  void Restart(uint64_t settling_ns) { *this = ArmRun(arm_, switch_epoch_, settling_ns); }
  // Begins the window of the next tick.
  void ClearWindow();

  uint32_t arm() const { return arm_; }
  uint32_t switch_epoch() const { return switch_epoch_; }
  uint64_t elapsed_ns() const { return elapsed_ns_; }
  const Window& window() const { return window_; }
  // Whether frames of the running tick were left out since they settle.
  bool settling_frames_seen() const { return settling_frames_seen_; }

  // References to every member of an ArmRun or const ArmRun, for the audit log.
  template <typename Self>
  static auto Fields(Self& run) {
    auto& [arm, switch_epoch, started, settling_frames_seen, elapsed_ns, settling_end_ns,
           measured_ns, window] = run;
    return std::tuple_cat(std::tie(arm, switch_epoch, started, settling_frames_seen, elapsed_ns,
                                   settling_end_ns, measured_ns),
                          Window::Fields(window));
  }

 private:
  bool SettlesAgain(const Frame& frame, uint64_t rebuild_settling_ns) const;
  void Advance(const Frame& frame);

  uint32_t arm_;
  uint32_t switch_epoch_;
  bool started_ = false;
  bool settling_frames_seen_ = false;
  uint64_t elapsed_ns_ = 0;
  uint64_t settling_end_ns_;
  uint64_t measured_ns_ = 0;  // since the last settling
  Window window_;
};

}  // namespace sweepstake::decision
