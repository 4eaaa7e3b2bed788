// Keeps the boxes of the next few steps of a scene, so that several broad phases can run on the
// same frames one after the other.
//
// Not thread-safe. Memory: at most 32 MiB of boxes plus one frame.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include "sweepstake/scene.h"

namespace sweepstake::cli {

inline constexpr size_t kMaxStepsInBlock = 20;
inline constexpr size_t kMaxBlockBytes = size_t{32} << 20;

class FrameBlock {
 public:
  // Steps the scene `step_count` times, or until kMaxStepsInBlock or kMaxBlockBytes is reached.
  // REQUIRES: `step_count` > 0.
  void Fill(Scene& scene, uint64_t step_count) {
    using std::chrono::steady_clock;
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

  size_t step_count() const { return ends_.size(); }
  std::span<const Aabb> BoxesOf(size_t step) const {
    const size_t begin = step == 0 ? 0 : ends_[step - 1];
    return std::span(boxes_).subspan(begin, ends_[step] - begin);
  }
  // Returns the time that the scene took to compute this step.
  uint64_t step_ns(size_t step) const { return step_ns_[step]; }

 private:
  std::vector<Aabb> boxes_;
  std::vector<size_t> ends_;
  std::vector<uint64_t> step_ns_;
};

}  // namespace sweepstake::cli
