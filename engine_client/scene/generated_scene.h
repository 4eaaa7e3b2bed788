// The base class of the computed scenes. It stores bodies as centres and half extents, which the
// derived class moves, and converts them to boxes.
//
// Not thread-safe. All memory is allocated at construction: 48 bytes per object here, plus the
// state of the derived scene.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sweepstake/aabb.h"
#include "sweepstake/scene.h"

namespace sweepstake {

// One array per axis, each with one element per object.
struct Bodies {
  explicit Bodies(uint32_t object_count);

  std::array<std::vector<float>, 3> centre;
  std::array<std::vector<float>, 3> half_extent;
};

class GeneratedScene : public Scene {
 public:
  std::string_view name() const final { return name_; }
  Aabb world() const final { return world_; }
  uint64_t frame_index() const final { return frame_index_; }
  std::span<const Aabb> aabbs() const final { return aabbs_; }
  void DoStep() final;

 protected:
  // `name` must outlive the scene. The derived class's constructor must place the bodies and then
  // call ShowBodies.
  GeneratedScene(std::string_view name, const Aabb& world, uint32_t object_count);

  // Moves the bodies by one step. frame_index() is already the index of the new frame.
  virtual void Move() = 0;

  void ShowBodies();
  Bodies& bodies() { return bodies_; }
  uint32_t object_count() const { return static_cast<uint32_t>(aabbs_.size()); }

 private:
  std::string_view name_;
  Aabb world_;
  uint64_t frame_index_ = 0;
  Bodies bodies_;
  std::vector<Aabb> aabbs_;
};

// Returns the world of the scenarios: ±half_extent on each axis.
Aabb CentredWorld(float half_extent);

// Draws the half extents: log-uniform, independently for each axis.
void SpawnSizes(const SceneOptions& options, Bodies& bodies);

// Draws the positions: uniform, with the whole box inside the world. REQUIRES: the half extents are
// drawn already.
void SpawnInsideWalls(const SceneOptions& options, Bodies& bodies);

// Returns `x` reflected at the wall that it passed, then clamped to [low, high].
float Reflect(float x, float low, float high);

}  // namespace sweepstake
