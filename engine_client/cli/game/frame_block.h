// The boxes of the next few steps of a scene, kept so that several broad phases can be shown the
// same frames one after the other.
//
// Not thread-safe. Memory: 32 MiB of boxes and one frame more at most.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sweepstake/scene.h"

namespace sweepstake::cli {

inline constexpr size_t kMostStepsInBlock = 20;
inline constexpr size_t kMostBlockBytes = size_t{32} << 20;

class FrameBlock {
 public:
  // Steps the scene: at least once, at most `step_count` times.
  void Fill(Scene& scene, uint64_t step_count);

  size_t step_count() const { return ends_.size(); }
  std::span<const Aabb> BoxesOf(size_t step) const;
  // How long the scene took for the step.
  uint64_t step_ns(size_t step) const { return step_ns_[step]; }

 private:
  std::vector<Aabb> boxes_;
  std::vector<size_t> ends_;
  std::vector<uint64_t> step_ns_;
};

}  // namespace sweepstake::cli
