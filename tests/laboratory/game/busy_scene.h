// A scene in a game that does other work in each frame, besides the scene's motion and the search.
// The work reads and writes kWorkBytes of memory until its time has passed, so that it displaces
// cached data as a game's work does. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sweepstake/scene.h"

namespace sweepstake::cli {

class BusyScene final : public Scene {
 public:
  static constexpr size_t kWorkBytes = size_t{4} << 20;

  // The work takes `work_ns` in each step; with 0 there is none. REQUIRES: `scene` is not null.
  BusyScene(std::unique_ptr<Scene> scene, uint64_t work_ns);

  std::string_view name() const override { return scene_->name(); }
  Aabb world() const override { return scene_->world(); }
  uint64_t frame_index() const override { return scene_->frame_index(); }
  std::span<const Aabb> aabbs() const override { return scene_->aabbs(); }
  size_t max_object_count() const override { return scene_->max_object_count(); }

 private:
  void DoStep() override;

  std::unique_ptr<Scene> scene_;
  uint64_t work_ns_;
  std::vector<uint64_t> memory_;  // empty if there is no work
  size_t next_ = 0;               // the word that the work changes next
};

}  // namespace sweepstake::cli
