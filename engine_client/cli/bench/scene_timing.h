// How long broad phases take per frame of a scene: taking all boxes and finding all pairs.
//
// All of them see the same frames in the same run. They take turns by blocks of up to 20 frames,
// and who begins rotates from block to block: a disturbance of the machine hits all alike, yet each
// runs with the warm caches that it would have alone.
// Before each measured call its boxes are written to memory, as a game has just done, and the
// threads of its executor are awake, as in a game whose jobs fill the frame.
//
// Not thread-safe. Times in milliseconds of the steady clock. Memory: up to 32 MiB of boxes, and
// 32 bytes per frame and broad phase.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine_client/cli/game/pair_oracle.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"

namespace sweepstake::cli {

// A broad phase that is compared.
struct Contestant {
  std::unique_ptr<BroadPhase> broad_phase;
  Executor* executor = nullptr;  // the broad phase's own; null where it has none
  // Stops after the frame in which its own time, Build included, has passed this.
  double cap_s = std::numeric_limits<double>::infinity();
  // Is shown only valid boxes (aabb.h); the ids of its pairs are then mapped to those of all boxes.
  bool sound_boxes_only = false;
};

// What one contestant did in steps 1, 2, … of the scene.
struct ContestantTiming {
  std::vector<double> step_ms;              // of each step it took
  std::vector<PairFingerprint> step_pairs;  // what it found in each
  uint64_t measured_count = 0;              // the last so many steps are the measured ones
  bool capped = false;
  double aabb_checks_mean = 0;    // per measured frame
  uint64_t bytes = 0;             // the most the broad phase held in a measured frame
  uint64_t bytes_with_pairs = 0;  // the same with the buffer that its pairs went into
};

// Builds on the scene's present frame, takes `warmup` steps unmeasured and then measures `frames`.
// A contestant that its cap stops within the warm-up has all its steps measured. REQUIRES: frames >
// 0. `on_step` hears the contestant and the steps it has done, outside of what is measured.
std::vector<ContestantTiming> TimeScene(
    Scene& scene, std::span<const Contestant> contestants, uint64_t warmup, uint64_t frames,
    const std::function<void(size_t contestant, uint64_t step)>& on_step);

struct TimeSummary {
  double ms_median = 0;
  double ms_mean = 0;
  double ms_min = 0;
  double ms_p99 = 0;
};
// REQUIRES: not empty.
TimeSummary Summarize(std::span<const double> times_ms);

// The value below which a share of `ratio` lies (nearest rank). REQUIRES: sorted, not empty.
double Quantile(const std::vector<double>& sorted, double ratio);

}  // namespace sweepstake::cli
