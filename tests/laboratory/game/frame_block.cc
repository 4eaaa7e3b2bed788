#include "tests/laboratory/game/frame_block.h"

#include <algorithm>
#include <chrono>

namespace sweepstake::cli {

using std::chrono::steady_clock;

void FrameBlock::Fill(Scene& scene, uint64_t step_count) {
  boxes_.clear();
  ends_.clear();
  step_ns_.clear();
  while (ends_.size() < std::min<uint64_t>(step_count, kMaxStepsInBlock) &&
         boxes_.size() * sizeof(Aabb) < kMaxBlockBytes) {
    const auto start = steady_clock::now();
    scene.Step();
    step_ns_.push_back(static_cast<uint64_t>((steady_clock::now() - start).count()));
    boxes_.insert(boxes_.end(), scene.aabbs().begin(), scene.aabbs().end());
    ends_.push_back(boxes_.size());
  }
}

std::span<const Aabb> FrameBlock::BoxesOf(size_t step) const {
  const size_t begin = step == 0 ? 0 : ends_[step - 1];
  return std::span(boxes_).subspan(begin, ends_[step] - begin);
}

}  // namespace sweepstake::cli
