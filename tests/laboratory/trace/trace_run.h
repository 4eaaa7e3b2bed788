// Times all arms on every frame of a scene, several times, and merges the runs into a cost trace.
//
// In every frame the arms take turns in a random order, so that disturbances of the machine and the
// cache contents left by the previous arm affect all of them alike. The control (a second structure
// of one arm) never runs next to its twin (the first one). Before each measured call the boxes are
// written to memory, as a game has just done. The scene advances in blocks of up to 20 frames whose
// boxes are kept. In every third block, fresh structures of the arms also run a burst
// (cost_trace.h) on the block's first frames.
//
// Every time in the trace is the lower quartile over `repeat_count` runs. Work that a backend does
// at a certain frame (a rebuild, a rebalanced tree) occurs there in every run and is kept. A
// disturbance only adds time, at a different frame in every run, and disappears unless it affects
// more than three quarters of the runs. The control's twin is the arm that is cheapest in the
// scene's first frames.
//
// Not thread-safe. Times are in nanoseconds. Cost: per run about 1.2 times the time of the arms'
// frames. Memory: 26 bytes per frame, arm and run.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/scene/random.h"
#include "sweepstake/scene.h"
#include "sweepstake/status.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

// The maximum object count at which the memory of a block (frame_block.h) still suffices for all
// frames of a burst.
inline constexpr uint32_t kMaxTracedObjects = 100'000;

struct TraceOptions {
  SceneChoice scene;
  std::vector<std::string> arms;  // as ChooseArms returns them
  uint32_t frame_count = 3000;    // kBurstFrames or more
  uint32_t repeat_count = 5;
};

// Measures the trace and calls `on_progress` with the share that is done. Errors: those of
// OpenScene and RunTracePass, and kInvalidArgument (more than kMaxTracedObjects objects).
Result<CostTrace> RunTrace(const TraceOptions& options,
                           const std::function<void(double share)>& on_progress);

// Merges several runs of a scene by the same arms. REQUIRES: at least one run; all have the same
// frames and arms.
CostTrace MergeRuns(std::vector<CostTrace> runs);

inline constexpr uint32_t kBurstFrames = 8;
inline constexpr uint32_t kBlocksPerBurst = 3;
// Steps of the scene before the trace's first frame, in which structures settle and caches warm up.
inline constexpr uint32_t kTraceWarmupFrames = 20;

struct TracePlan {
  std::vector<std::string> arms;  // names of known arms
  uint32_t control_arm = 0;
  std::vector<uint64_t> frame_ns;  // approximate time of a frame, per arm
  uint32_t frame_count = 0;
  uint64_t order_seed = 0;  // determines the order of the arms in each frame
};

// Runs the scene once and returns a trace without scene, seed, machine and repeat_count. Between
// blocks `on_frame` is called with the number of frames done. Error: kInternal (two arms found
// different numbers of pairs). REQUIRES: frame_count >= kBurstFrames; the scene is at its start,
// and its blocks hold at least kBurstFrames frames.
Result<CostTrace> RunTracePass(Scene& scene, const TracePlan& plan,
                               const std::function<void(uint32_t frames_done)>& on_frame);

enum class ArmTurn {
  kEveryFrame,
  kLastFrame,  // the block's last frame, after one unmeasured frame
  kNone,
};

// An arm whose frame costs more than kSparseRatio times the cheapest arm's is measured sparsely:
// once per block, on the last frame. An unmeasured frame before it brings the structure up to date.
// If even these frames would take more than kSparseShare of the total time, the arm skips blocks.
// It is measured again once the scene has lost enough objects (kFewerRatio) for the arm to be fast.
class ArmPace {
 public:
  // Four times the ratio between the slowest and the fastest arm in scenes with up to 3,000
  // objects. In such scenes all arms are therefore measured on every frame.
  static constexpr uint64_t kSparseRatio = 16;
  static constexpr double kSparseShare = 0.1;
  // A skipped arm is measured again if fewer than this share of the objects are left.
  static constexpr double kFewerRatio = 0.875;

  // `frame_ns` is the approximate time of a frame, per arm.
  explicit ArmPace(std::span<const uint64_t> frame_ns) {
    for (const uint64_t ns : frame_ns) arms_.push_back({.frame_ns = ns});
  }

  // Returns how the arm is measured in a block whose frames hold `object_count` objects.
  ArmTurn TurnOf(size_t arm, size_t object_count) const {
    const auto cheapest =
        std::min_element(arms_.begin(), arms_.end(),
                         [](const Arm& a, const Arm& b) { return a.frame_ns < b.frame_ns; });
    const Arm& asked = arms_[arm];
    if (asked.frame_ns <= kSparseRatio * cheapest->frame_ns) return ArmTurn::kEveryFrame;
    const bool affordable =
        static_cast<double>(asked.sparse_ns) <= kSparseShare * static_cast<double>(total_ns_);
    const bool fewer =
        static_cast<double>(object_count) < kFewerRatio * static_cast<double>(asked.object_count);
    return affordable || fewer ? ArmTurn::kLastFrame : ArmTurn::kNone;
  }
  // Records a turn in which a frame of the arm took `frame_ns` and all its frames took `spent_ns`.
  void Note(size_t arm, ArmTurn turn, size_t object_count, uint64_t frame_ns, uint64_t spent_ns) {
    Arm& noted = arms_[arm];
    noted.frame_ns = frame_ns;
    noted.object_count = object_count;
    if (turn == ArmTurn::kLastFrame) noted.sparse_ns += spent_ns;
    total_ns_ += spent_ns;
  }

 private:
  struct Arm {
    uint64_t frame_ns = 0;
    uint64_t sparse_ns = 0;  // time spent in sparse turns
    size_t object_count = 0;
  };

  std::vector<Arm> arms_;
  uint64_t total_ns_ = 0;
};

// Draws a random order of the contestants for each frame. The last contestant, the A/A control, and
// its twin (contestant `twin`) are never neighbours. Otherwise one would find the caches as the
// other left them. The seed determines all orders. A draw costs a few nanoseconds per contestant.
class TurnOrder {
 public:
  // REQUIRES: twin < contestant_count - 1.
  TurnOrder(size_t contestant_count, size_t twin, uint64_t seed)
      : order_(contestant_count), twin_(twin), random_(seed) {
    std::iota(order_.begin(), order_.end(), size_t{0});
  }

  // Returns all contestants in the next order, valid until the next call. The last contestant of
  // one order counts as the neighbour of the first one of the next. With only two contestants the
  // control and its twin are always neighbours.
  const std::vector<size_t>& Next() {
    // The maximum number of random orders to try until the control and its twin are apart. With
    // three contestants some six are needed on average, with more contestants fewer.
    constexpr int kMaxDraws = 1000;
    const size_t last = order_.back();
    for (int draw = 0; draw < kMaxDraws; ++draw) {
      Shuffle();
      if (order_.size() < 3 || !HasTwinsTogether(last)) break;
    }
    return order_;
  }

 private:
  void Shuffle() {
    for (size_t left = order_.size(); left > 1; --left) {
      std::swap(order_[left - 1], order_[random_.Below(left)]);
    }
  }
  bool HasTwinsTogether(size_t before) const {
    for (const size_t contestant : order_) {
      if (AreTwins(before, contestant)) return true;
      before = contestant;
    }
    return false;
  }
  bool AreTwins(size_t a, size_t b) const {
    const size_t control = order_.size() - 1;
    return (a == twin_ && b == control) || (a == control && b == twin_);
  }

  std::vector<size_t> order_;
  size_t twin_;
  SequentialRandom random_;
};

}  // namespace sweepstake::cli
