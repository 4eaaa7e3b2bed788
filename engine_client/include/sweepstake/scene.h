// Moving boxes to run a broad phase on: the paper's five scenarios, the reference suite, and
// recorded files.
//
// One seed gives the same boxes bit for bit on every platform, whatever the frame rate. Not
// thread-safe; distinct scenes are independent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sweepstake/aabb.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Defaults in the spirit of the paper (§6.1); lengths in world units, times in seconds. Validated
// by MakeScene.
struct SceneOptions {
  uint32_t object_count = 1000;       // 0 to 16,777,216
  uint64_t spawn_seed = 1;            // positions and sizes
  uint64_t motion_seed = 1;           // kicks and directions
  float world_half_extent = 50;       // the world is ±this on each axis
  float fixed_step_s = 1.0F / 60.0F;  // one Step; > 0
  float half_extent_min = 0.145F;     // object half extents are log-uniform in [min, max] per axis
  float half_extent_max = 0.725F;
  float speed = 10;                // scenario's characteristic speed, units/s (see scene/README.md)
  float gravity = 9.81F;           // units/s²
  float direction_interval_s = 3;  // rotating-gravity: time per direction
};

class Scene {
 public:
  virtual ~Scene() = default;

  virtual std::string_view name() const = 0;
  // Bounds of the motion; boxes may stick out by their size.
  virtual Aabb world() const = 0;
  // Steps taken; 0 is the spawn state, which aabbs() shows at once.
  virtual uint64_t frame_index() const = 0;
  // The boxes of this frame, valid until the next Step. The count may change in recorded files
  // only.
  virtual std::span<const Aabb> aabbs() const = 0;
  // One fixed step on. A recorded file starts again after its last frame. Does not allocate after
  // the first call.
  virtual void Step() = 0;
};

// The names MakeScene knows: brownian, rotating-gravity, hurricane, free-fall, random-gravity,
// suite-b, suite-g, suite-h.
std::span<const std::string_view> SceneNames();

// `scene` is one of SceneNames() or the path of a .aabbs file (options then are not used). The
// suite takes only object_count: it is fixed otherwise (scene/README.md). kNotFound lists the
// names; kInvalidArgument names the option; kDataLoss says in one line what is broken in the file.
Result<std::unique_ptr<Scene>> MakeScene(std::string_view scene, const SceneOptions& options);

// Steps `scene` `frame_count` times and writes it as Broadmark's .aabbs (1 + frame_count frames,
// spawn state first). The file appears whole or not at all.
Status RecordScene(Scene& scene, uint64_t frame_count, const std::filesystem::path& path);

}  // namespace sweepstake
