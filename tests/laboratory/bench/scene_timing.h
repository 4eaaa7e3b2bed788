// Measures how long each broad phase takes per frame of a scene to read all boxes and find all
// pairs.
//
// All broad phases see the same frames in the same run. They take turns in blocks of up to 20
// frames, and the order rotates from block to block. A disturbance of the machine therefore affects
// all of them alike. Each broad phase still has warm caches within its block, as if it ran alone.
// Before each measured call, the boxes are written to memory and the threads of the executor are
// woken, as in a game that has just moved its objects in parallel jobs. In a cold run, 32 MiB of
// other memory are read and written before that, as the rest of a game's frame might do. This
// evicts the data of the broad phase from the caches of one core.
//
// Not thread-safe. Times in milliseconds of the steady clock. Memory: up to 32 MiB of boxes, and
// 32 bytes per frame and broad phase.
//
// Contestants may have different instruction sets (simd.h). The instruction set of a contestant is
// chosen before its turn, outside the measured time.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/laboratory/game/pair_oracle.h"

namespace sweepstake::cli {

// A broad phase to be measured.
struct Contestant {
  std::unique_ptr<BroadPhase> broad_phase;
  Executor* executor = nullptr;  // the executor that this broad phase uses; null if none
  // The contestant stops after the frame in which its own time, Build included, exceeds this.
  double cap_s = std::numeric_limits<double>::infinity();
  // If true, only valid boxes (aabb.h) are passed to the contestant, and the ids of its pairs are
  // mapped back afterwards.
  bool valid_boxes_only = false;
  // The instruction set of this contestant for the whole run: one of SimdTargets(). Empty: the set
  // in use when the run begins.
  std::string simd{};
};

// The times and pairs of one contestant in steps 1, 2, … of the scene.
struct ContestantTiming {
  std::vector<double> step_ms;              // one per step
  std::vector<PairFingerprint> step_pairs;  // one per step
  uint64_t measured_count = 0;              // number of measured steps; they are the last steps
  bool capped = false;
  double aabb_checks_mean = 0;    // per measured frame
  uint64_t bytes = 0;             // memory of the broad phase, maximum over the measured frames
  uint64_t bytes_with_pairs = 0;  // `bytes` plus the pair buffer
};

struct TimingPlan {
  uint64_t warmup = 0;  // unmeasured steps before the measured ones
  uint64_t frames = 1;  // measured steps, at least 1
  bool cold = false;    // caches are evicted before each step
};

// Builds every contestant on the scene's current frame, then runs the steps of the plan. If the cap
// stops a contestant within the warm-up, all its steps count as measured. `on_step` is called
// outside of the measured time, with the contestant and the number of steps it has done. The
// instruction set in use before the call is selected again at the end.
std::vector<ContestantTiming> TimeScene(
    Scene& scene, std::span<const Contestant> contestants, const TimingPlan& plan,
    const std::function<void(size_t contestant, uint64_t step)>& on_step);

}  // namespace sweepstake::cli
