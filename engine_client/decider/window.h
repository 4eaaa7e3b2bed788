// The frames of one switch epoch since the last decision tick, and their mean costs (paper §4).
//
// The sums are doubles, so no input overflows them. Frames are added in their order, so the sums
// have the same bits on every platform.
#pragma once

#include <cstdint>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// The metrics from which a reward is computed.
struct WindowMetrics {
  double fps = 0;           // frames ÷ unscaled time; infinite if the frames took no time
  double detection_ms = 0;  // mean of update and search per frame
  // Mean detection time of the calm frames: frames with a search, each limited to twice the typical
  // time of the run. The limit removes interruptions of the frame thread, which make a few frames
  // many times longer and are not a cost of the arm. It is not applied if more than a fifth of the
  // frames exceed it. Frames without a search are left out, so that the mean does not depend on how
  // often a game searches.
  double calm_detection_ms = 0;
  double native_mib = 0;  // maximum over the frames
  // Checks ÷ n(n−1)/2, both summed over the frames. If the frames had no pairs, it is 0 without
  // checks and 1 with checks.
  double check_ratio = 0;
  bool IsFinite() const;
};

class Window {
 public:
  // Adds a frame. A frame with kFrameRebuild counts in all metrics except the two detection means,
  // which describe ordinary frames. If every frame of the window is a rebuild frame (the object
  // count changes all the time), the means are over all frames.
  void Add(const FrameSample& frame);
  // Adds the frames of a later window of the same run.
  void Add(const Window& later);
  // Begins the next window of the same run and keeps the typical time.
  void Clear();

  bool empty() const { return frame_count_ == 0; }
  uint64_t frame_count() const { return frame_count_; }
  // Returns whether the window shows the cost of its arm. That holds if a frame searched without a
  // rebuild, or if all frames rebuilt and detection took time. A game in a menu may show neither.
  bool shows_cost() const {
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
  double calm_detection_ns_ = 0;     // sum; each frame limited to twice the typical time
  uint64_t calm_frame_count_ = 0;    // ordinary frames with a search
  uint64_t long_frame_count_ = 0;    // frames above twice the typical time
  double typical_detection_ns_ = 0;  // approximate median of the run's searches; 0: no search yet
  double rebuild_detection_ns_ = 0;
  double check_count_ = 0;
  double pair_count_ = 0;  // n(n−1)/2, summed over the frames
  uint64_t peak_bytes_ = 0;
};

}  // namespace sweepstake::decision
