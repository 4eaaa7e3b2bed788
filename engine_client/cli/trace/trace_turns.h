// Which arms a trace measures in which frames, and in which order.
//
// ArmPace says how often: on every frame, unless an arm is so slow that nobody would choose it and
// it would make the trace take hours. TurnOrder says who runs when within a frame. Neither is
// thread-safe. Times are in nanoseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake::cli {

enum class ArmTurn {
  kEveryFrame,
  kLastFrame,  // of the block, after one frame before it that is not measured
  kNone,
};

// An arm whose frame costs more than kSparseRatio times the cheapest one's is measured sparsely:
// once per block, on the last frame, after one more that catches up with the frames it has not
// seen. Where even that would take more than kSparseShare of the whole time, the arm sits blocks
// out, unless the scene has lost so many objects meanwhile that the arm may have become a good one.
class ArmPace {
 public:
  // Four times the spread of the arms up to 3,000 objects: those are all measured on every frame.
  static constexpr uint64_t kSparseRatio = 16;
  static constexpr double kSparseShare = 0.1;
  // The scene has lost "so many objects" when less than this share of them is left.
  static constexpr double kFewerRatio = 0.875;

  // `frame_ns` is roughly what a frame costs each arm.
  explicit ArmPace(std::span<const uint64_t> frame_ns);

  // The turn in a block whose frames hold `object_count` objects.
  ArmTurn TurnOf(size_t arm, size_t object_count) const;
  // Takes note of a turn: a frame of the arm took `frame_ns`, all its frames `spent_ns`.
  void Note(size_t arm, ArmTurn turn, size_t object_count, uint64_t frame_ns, uint64_t spent_ns);

 private:
  struct Arm {
    uint64_t frame_ns = 0;
    uint64_t sparse_ns = 0;  // spent in sparse turns
    size_t object_count = 0;
  };

  std::vector<Arm> arms_;
  uint64_t total_ns_ = 0;
};

// Draws the order of a frame's contestants anew each time. The last contestant, the A/A control,
// and its twin are never neighbours, so that neither finds the caches as the other left them.
// Deterministic by seed. A draw costs some nanoseconds per contestant.
class TurnOrder {
 public:
  // REQUIRES: twin < contestant_count - 1.
  TurnOrder(size_t contestant_count, size_t twin, uint64_t seed);

  // All contestants; valid until the next call. The last contestant of one order counts as the
  // neighbour of the first one of the next. Two contestants cannot be kept apart.
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
