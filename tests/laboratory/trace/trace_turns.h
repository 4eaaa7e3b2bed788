// Decides which arms a trace measures in which frames, and in which order.
//
// ArmPace decides how often an arm is measured: on every frame, unless it is so slow that no policy
// would choose it and the trace would take hours. TurnOrder decides the order within a frame.
// Neither is thread-safe. Times are in nanoseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake::cli {

enum class ArmTurn {
  kEveryFrame,
  kLastFrame,  // the block's last frame, after one unmeasured frame
  kNone,
};

// An arm whose frame costs more than kSparseRatio times the cheapest one's is measured sparsely:
// once per block, on the last frame, after an unmeasured frame that catches up with the skipped
// ones. If even that would take more than kSparseShare of the whole time, the arm skips blocks,
// unless the scene has lost so many objects since then that the arm may have become fast.
class ArmPace {
 public:
  // Four times the ratio between the slowest and the fastest arm in scenes up to 3,000 objects, so
  // that all arms are measured on every frame there.
  static constexpr uint64_t kSparseRatio = 16;
  static constexpr double kSparseShare = 0.1;
  // The scene has lost "so many objects" if less than this share of them is left.
  static constexpr double kFewerRatio = 0.875;

  // `frame_ns` is the approximate time of a frame, per arm.
  explicit ArmPace(std::span<const uint64_t> frame_ns);

  // Returns the arm's turn in a block whose frames hold `object_count` objects.
  ArmTurn TurnOf(size_t arm, size_t object_count) const;
  // Records a turn in which a frame of the arm took `frame_ns` and all its frames took `spent_ns`.
  void Note(size_t arm, ArmTurn turn, size_t object_count, uint64_t frame_ns, uint64_t spent_ns);

 private:
  struct Arm {
    uint64_t frame_ns = 0;
    uint64_t sparse_ns = 0;  // time spent in sparse turns
    size_t object_count = 0;
  };

  std::vector<Arm> arms_;
  uint64_t total_ns_ = 0;
};

// Draws a random order of the contestants for each frame. The last contestant, which is the A/A
// control, and its twin are never neighbours, so that neither finds the caches as the other left
// them. The seed determines all orders. A draw costs a few nanoseconds per contestant.
class TurnOrder {
 public:
  // REQUIRES: twin < contestant_count - 1.
  TurnOrder(size_t contestant_count, size_t twin, uint64_t seed);

  // Returns all contestants in the next order, valid until the next call. The last contestant of
  // one order counts as the neighbour of the first one of the next. With only two contestants the
  // control and its twin are always neighbours.
  const std::vector<size_t>& Next();

 private:
  void Shuffle();
  bool HasTwinsTogether(size_t before) const;
  bool AreTwins(size_t a, size_t b) const;

  std::vector<size_t> order_;
  size_t twin_;
  SequentialRandom random_;
};

}  // namespace sweepstake::cli
