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
// by MakeScene: a value outside its range, or not finite, is kInvalidArgument. What each scenario
// makes of them: scene/README.md.
struct SceneOptions {
  uint32_t object_count = 1000;       // 0 to 16,777,216
  uint64_t spawn_seed = 1;            // sizes and spawn positions
  uint64_t motion_seed = 1;           // start velocities, directions and kicks
  float world_half_extent = 50;       // the world is ±this on each axis; 1e-3 to 1e6
  float fixed_step_s = 1.0F / 60.0F;  // one Step; 1e-6 to 1
  // Object half extents are log-uniform in [min, max] per axis; 1e-6 <= min <= max <=
  // world_half_extent.
  float half_extent_min = 0.5F;
  float half_extent_max = 2.5F;
  float speed = 10;                // characteristic speed, units/s; 0 to 1e6
  float gravity = 9.81F;           // units/s²; 0 to 1e6
  float direction_interval_s = 3;  // rotating-gravity: time per direction; 1e-6 to 1e6
};

class Scene {
 public:
  virtual ~Scene() = default;

  virtual std::string_view name() const = 0;
  // Bounds of the motion; boxes may stick out by their size, in suite-h by 1/40 of the side more.
  // In a recorded file what its header says.
  virtual Aabb world() const = 0;
  // Steps taken; 0 is the spawn state, which aabbs() shows at once.
  virtual uint64_t frame_index() const = 0;
  // The boxes of this frame, valid until the next Step. Of the scenes that MakeScene makes, only
  // a recorded file may change the count.
  virtual std::span<const Aabb> aabbs() const = 0;
  // One fixed step on; does not allocate and does not fail. A recorded file starts again after its
  // last frame, while frame_index() goes on; should it have become unreadable since it was opened,
  // the boxes stay as they are. Cost: 15 to 90 ns per object (the hurricanes), or reading 32 bytes.
  virtual void Step() = 0;
};

// The names MakeScene knows: brownian, rotating-gravity, hurricane, free-fall, random-gravity,
// suite-b, suite-g, suite-h.
std::span<const std::string_view> SceneNames();

// `scene` is one of SceneNames() or the path of a .aabbs file, in UTF-8 (options then are not
// used). The suite takes only object_count: it is fixed otherwise (scene/README.md). kNotFound
// lists the names; kInvalidArgument names the option; kDataLoss says in one line what is broken in
// the file; kResourceExhausted: more objects in the file than object_count may be, or no memory for
// them.
Result<std::unique_ptr<Scene>> MakeScene(std::string_view scene, const SceneOptions& options);

// Steps `scene` `frame_count` times and writes it as Broadmark's .aabbs (1 + frame_count frames,
// the state it is in first). The file appears whole or not at all; one that was there is replaced.
// kInvalidArgument: a coordinate is not finite, no frame has an object, frame_count is over
// 2^31 - 1, or `path` is no file name; kNotFound: no such directory; kUnavailable: the system's
// reason (Windows replaces no file that is open, a scene being replayed from it included). Takes 4
// bytes of memory per frame besides one frame.
Status RecordScene(Scene& scene, uint64_t frame_count, const std::filesystem::path& path);

}  // namespace sweepstake
