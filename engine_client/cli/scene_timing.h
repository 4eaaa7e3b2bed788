// How long one arm takes per frame of a scene: taking all boxes and finding all pairs.
// Not thread-safe. Times in milliseconds of the steady clock.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"

namespace sweepstake::cli {

struct ArmTiming {
  uint64_t frame_count = 0;
  double ms_median = 0;
  double ms_mean = 0;
  double ms_min = 0;
  double ms_p99 = 0;
  double pairs_mean = 0;
  double aabb_checks_mean = 0;
  uint64_t bytes = 0;  // the most the backend held in a measured frame
};

// Builds on the scene's present frame, takes `warmup` steps unmeasured and then measures `frames`.
// REQUIRES: frames > 0. `on_frame` hears the number of steps done, outside of what is measured.
ArmTiming TimeScene(Scene& scene, BroadPhase& arm, uint64_t warmup, uint64_t frames,
                    const std::function<void(uint64_t)>& on_frame);

// The value below which a share of `ratio` lies (nearest rank). REQUIRES: sorted, not empty.
double Quantile(const std::vector<double>& sorted, double ratio);

// The middle value, or the mean of the two middle ones. REQUIRES: sorted, not empty.
double Median(const std::vector<double>& sorted);

}  // namespace sweepstake::cli
