// How often a trace measures an arm: on every frame, unless it is so slow that nobody would choose
// it and it would make the trace take hours.
//
// An arm whose frame costs more than kSparseRatio times the cheapest one's is measured sparsely:
// once per block, on the last frame, after one more that catches up with the frames it has not
// seen. Where even that would take more than kSparseShare of the whole time it sits blocks out,
// unless the scene has lost so many objects meanwhile that the arm may have become a good one.
//
// Not thread-safe. Nanoseconds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::cli {

enum class ArmTurn {
  kEveryFrame,
  kLastFrame,  // of the block, after an unmeasured one before it
  kNone,
};

class ArmPace {
 public:
  // Four times the spread of the arms up to 3,000 objects: those are all measured on every frame.
  static constexpr uint64_t kSparseRatio = 16;
  static constexpr double kSparseShare = 0.1;
  // "So many": an eighth.
  static constexpr double kFewerRatio = 0.875;

  // What a frame costs each arm, roughly.
  explicit ArmPace(std::span<const uint64_t> frame_ns);

  // For a block whose frames hold `object_count` objects.
  ArmTurn TurnOf(size_t arm, size_t object_count) const;
  // An arm had its turn: a frame of it took `frame_ns`, all its frames `spent_ns`.
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

}  // namespace sweepstake::cli
