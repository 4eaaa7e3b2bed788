// Scenes of moving boxes that reveal faults of a broad phase: ordinary, degenerate and broken
// boxes, and seeded mixtures of all kinds.
//
// The same kind, count and seed give the same boxes on every platform. Not thread-safe. Lengths are
// in world units. Unless a kind says otherwise, the world has one object per unit of volume and
// half extents are 0.145 to 0.725.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/aabb.h"
#include "sweepstake/scene.h"

namespace sweepstake {

class BoxScene {
 public:
  // REQUIRES: `kind` is "brownian" or a name in SceneNames(SceneGroup::kDegenerate), except the
  // five names listed below.
  BoxScene(std::string_view kind, size_t count, uint64_t seed);

  std::span<const Aabb> boxes() const { return boxes_; }
  void Step();

 private:
  std::vector<Aabb> boxes_;
  std::vector<size_t> kinds_;  // the kind of each box
  SequentialRandom random_;
  uint64_t frame_ = 0;
};

// Makes a BoxScene as a Scene. `name` is a kind, or one of these:
// - empty, one, two: the scene has 0, 1 or 2 objects, whatever object_count is
// - count-changing: a mixture with another number of objects in every frame, in some frames none
// - spawning: brownian; the count falls to half of object_count and rises again, by 1/64 per frame
//
// `name` must outlive the scene. `object_count` is the maximum of a frame. REQUIRES: a known name.
std::unique_ptr<Scene> MakeDegenerateScene(std::string_view name, uint32_t object_count,
                                           uint64_t seed);

}  // namespace sweepstake
