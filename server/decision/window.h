// The frames since the last decision tick in one switch epoch, and what they cost on average (paper
// §4).
//
// Plain sums in double: no input overflows them, and the order of the frames is the only order
// there is.
#pragma once

#include <cstdint>
#include <tuple>

#include "server/decision/types.h"

namespace sweepstake::decision {

// A window in the reward's terms.
struct WindowMetrics {
  double fps = 0;           // frames ÷ unscaled time; infinite where the frames took no time
  double detection_ms = 0;  // mean per frame: update and search
  double native_mib = 0;    // peak
  double check_ratio =
      0;  // checks ÷ n(n−1)/2, both summed over the frames; 0 and 1 where there is no pair at all
  bool IsFinite() const;
};

class Window {
 public:
  // A frame with kFrameRebuild counts in everything but the detection mean, which is that of the
  // arm's ordinary frames. Where every frame of the window rebuilt (the object count changes all
  // the time), rebuilding is what the arm costs, and the mean is over all of them.
  void Add(const Frame& frame);
  void Clear() { *this = Window(); }

  bool empty() const { return frame_count_ == 0; }
  uint64_t frame_count() const { return frame_count_; }
  // REQUIRES: !empty().
  WindowMetrics Metrics() const;

  // References to every member of a Window or const Window, for the audit log.
  template <typename Self>
  static auto Fields(Self& window) {
    auto& [frame_count, ordinary_frame_count, time_ns, ordinary_detection_ns, rebuild_detection_ns,
           check_count, pair_count, peak_bytes] = window;
    return std::tie(frame_count, ordinary_frame_count, time_ns, ordinary_detection_ns,
                    rebuild_detection_ns, check_count, pair_count, peak_bytes);
  }

 private:
  uint64_t frame_count_ = 0;
  uint64_t ordinary_frame_count_ = 0;  // without those that rebuilt
  double time_ns_ = 0;
  double ordinary_detection_ns_ = 0;
  double rebuild_detection_ns_ = 0;
  double check_count_ = 0;
  double pair_count_ = 0;  // of all objects with each other
  uint64_t peak_bytes_ = 0;
};

}  // namespace sweepstake::decision
