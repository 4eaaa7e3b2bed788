// Moving boxes to run a broad phase on: the paper's five scenarios, the reference suite, scenes
// that change, degenerate scenes, and recorded files.
//
// The same seed gives the same boxes bit for bit on every platform, whatever the frame rate. Not
// thread-safe; distinct scenes are independent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sweepstake/aabb.h"
#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

inline constexpr uint32_t kMaxSceneObjectCount = 16'777'216;

// Defaults follow the paper (§6.1); lengths in world units, times in seconds. MakeScene validates
// them: a value that is outside its range or not finite is kInvalidArgument. scene/README.md
// describes how each scenario uses them.
struct SceneOptions {
  uint32_t object_count = 1000;       // 0 to kMaxSceneObjectCount
  uint64_t spawn_seed = 1;            // seed of sizes and spawn positions
  uint64_t motion_seed = 1;           // seed of start velocities, directions, kicks and wall hits
  float world_half_extent = 50;       // the world is ±this on each axis; 1e-3 to 1e6
  float fixed_step_s = 1.0F / 60.0F;  // duration of one Step; 1e-6 to 1
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
  // Returns the bounds of the motion. Boxes may extend beyond them by their size, in suite-h by
  // another 1/40 of the world's side. For a recorded file these are the bounds in its header.
  // Degenerate scenes leave their bounds.
  virtual Aabb world() const = 0;
  // Returns the number of steps taken. At 0, aabbs() returns the boxes as they were spawned.
  virtual uint64_t frame_index() const = 0;
  // Returns the boxes of this frame, valid until the next Step. Only recorded files, changing and
  // degenerate scenes may change the count.
  virtual std::span<const Aabb> aabbs() const = 0;
  // Returns the largest count that a frame can have.
  virtual size_t max_object_count() const { return aabbs().size(); }
  // Advances the scene by one fixed step; does not allocate and does not fail. A recorded file
  // starts again after its last frame, while frame_index() goes on. If the file has become
  // unreadable, the boxes stay unchanged. Cost: O(objects); for a recorded file, reading the
  // frame.
  //
  // The boxes do not depend on the caller's floating-point environment.
  void Step();

 private:
  // Called by Step, in the default floating-point environment.
  virtual void DoStep() = 0;
};

enum class SceneGroup : uint8_t {
  kReference,   // the five scenarios brownian, rotating-gravity, hurricane, free-fall and
                // random-gravity, and the reference suite suite-b, suite-g and suite-h
  kChanging,    // the cheapest broad phase changes over time
  kDegenerate,  // reveals faults of a broad phase: broken boxes, extreme sizes, changing counts
};

struct SceneDescription {
  std::string_view name;
  SceneGroup group;
  std::string_view summary;  // a few words
};

// Returns every scene that MakeScene finds by name, by group. The names end with NUL.
std::span<const SceneDescription> SceneDescriptions();
std::span<const std::string_view> SceneNames();
std::span<const std::string_view> SceneNames(SceneGroup group);

// Makes a scene. `scene` is one of SceneNames() or the path of a .aabbs file, in UTF-8. The
// scenarios use every option, the suite only object_count, the changing and degenerate scenes
// object_count and spawn_seed, a file none.
//
// Errors: kNotFound lists the names, the nearest first. kInvalidArgument names the option.
// kDataLoss states in one line what is broken in the file. kResourceExhausted: the file has more
// than kMaxSceneObjectCount objects, or memory ran out.
Result<std::unique_ptr<Scene>> MakeScene(std::string_view scene, const SceneOptions& options);

// Steps `scene` `frame_count` times and writes it as Broadmark's .aabbs (1 + frame_count frames,
// its present state first) to `path`, in UTF-8. The file is written completely or not at all, and
// replaces an existing one. The file contains `notes`, any text of at most 16 MiB, unchanged.
// Memory: one frame, and 4 bytes for each frame.
//
// Errors: kInvalidArgument: a coordinate is not finite, no frame has an object, frame_count is over
// 2^31 - 1, or `path` is not a file name; kNotFound: no such directory; kUnavailable: the system's
// reason. Windows does not replace an open file, such as the file that a scene is replayed from.
Status RecordScene(Scene& scene, uint64_t frame_count, std::string_view path,
                   std::string_view notes = {});

// Returns the notes of the .aabbs file at `path`, in UTF-8; empty if it has none. Errors: those of
// MakeScene with that file.
Result<std::string> RecordedNotes(std::string_view path);

}  // namespace sweepstake

#include "sweepstake/names/end.h"
