// The frames since the last decision tick in one switch epoch, and their mean costs (paper §4).
//
// The sums are doubles, so that no input overflows them. They are added in the order of the frames,
// so that the result has the same bits everywhere.
#pragma once

#include <cstdint>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// The metrics of a window that a reward is computed from.
struct WindowMetrics {
  double fps = 0;           // frames ÷ unscaled time; infinite if the frames took no time
  double detection_ms = 0;  // mean of update and search per frame
  // The mean over the calm frames: frames with a search, each limited to twice the typical time of
  // the run. If more than a fifth of the frames are longer, they are not limited. An interruption
  // of the frame thread lengthens a few frames to many times their time, and is not a cost of the
  // arm; nor is the number of searches that a game makes.
  double calm_detection_ms = 0;
  double native_mib = 0;  // maximum
  // Checks ÷ n(n−1)/2, both summed over the frames. Without any pair it is 0 if nothing was
  // checked, else 1.
  double check_ratio = 0;
  bool IsFinite() const;
};

class Window {
 public:
  // A frame with kFrameRebuild counts in every metric except the detection means, which are those
  // of the arm's ordinary frames. If every frame of the window rebuilt, because the object count
  // changes all the time, the mean is over all frames: rebuilding is part of the arm's cost.
  void Add(const FrameSample& frame);
  // Begins the next window of the same run. The typical time is kept.
  void Clear();

  bool empty() const { return frame_count_ == 0; }
  uint64_t frame_count() const { return frame_count_; }
  // Returns whether the window shows the cost of its arm: a frame searched without a rebuild, or
  // all of them rebuilt. In a menu there may be none.
  bool tells_cost() const {
    return calm_frame_count_ > 0 || (ordinary_frame_count_ == 0 && rebuild_detection_ns_ > 0);
  }
  // REQUIRES: !empty().
  WindowMetrics Metrics() const;

  // Calls visit(name, member) for every member, for the audit log (audit/audit_row.h).
  template <typename Self, typename Visit>
  static void VisitFields(Self& window, Visit& visit) {
    auto& [frame_count, ordinary_frame_count, time_ns, ordinary_detection_ns, calm_detection_ns,
           calm_frame_count, long_frame_count, typical_detection_ns, rebuild_detection_ns,
           check_count, pair_count, peak_bytes] = window;
    visit("frame_count", frame_count);
    visit("ordinary_frame_count", ordinary_frame_count);
    visit("time_ns", time_ns);
    visit("ordinary_detection_ns", ordinary_detection_ns);
    visit("calm_detection_ns", calm_detection_ns);
    visit("calm_frame_count", calm_frame_count);
    visit("long_frame_count", long_frame_count);
    visit("typical_detection_ns", typical_detection_ns);
    visit("rebuild_detection_ns", rebuild_detection_ns);
    visit("check_count", check_count);
    visit("pair_count", pair_count);
    visit("peak_bytes", peak_bytes);
  }

 private:
  void AddCalm(double detection_ns);

  uint64_t frame_count_ = 0;
  uint64_t ordinary_frame_count_ = 0;  // frames that did not rebuild
  double time_ns_ = 0;
  double ordinary_detection_ns_ = 0;
  double calm_detection_ns_ = 0;     // each frame limited to twice the typical time
  uint64_t calm_frame_count_ = 0;    // ordinary frames with a search
  uint64_t long_frame_count_ = 0;    // frames above twice the typical time
  double typical_detection_ns_ = 0;  // near the median of the run's searches; 0: none yet
  double rebuild_detection_ns_ = 0;
  double check_count_ = 0;
  double pair_count_ = 0;  // n(n−1)/2, summed over the frames
  uint64_t peak_bytes_ = 0;
};

}  // namespace sweepstake::decision
