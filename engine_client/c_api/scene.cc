#include "sweepstake/scene.h"

#include <bit>
#include <memory>

#include "engine_client/c_api/live.h"
#include "engine_client/c_api/sized_struct.h"
#include "engine_client/math/hash.h"

using sweepstake::Aabb;
using sweepstake::SceneNames;
using sweepstake::SceneOptions;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

struct OwnScene {
  static constexpr swp_kind kKind = SWP_KIND_SCENE;
  static constexpr std::string_view kName = "scene";

  std::unique_ptr<sweepstake::Scene> scene;
};

SceneOptions ToSceneOptions(const swp_scene_options& given) {
  SceneOptions options;
  options.object_count = given.object_count;
  options.spawn_seed = given.spawn_seed;
  options.motion_seed = given.motion_seed;
  options.world_half_extent = given.world_half_extent;
  options.fixed_step_s = given.fixed_step_s;
  options.half_extent_min = given.half_extent_min;
  options.half_extent_max = given.half_extent_max;
  options.speed = given.speed;
  options.gravity = given.gravity;
  options.direction_interval_s = given.direction_interval_s;
  return options;
}

swp_scene_options DefaultSceneOptions() {
  const SceneOptions defaults;
  return {sizeof(swp_scene_options), defaults.object_count,         defaults.spawn_seed,
          defaults.motion_seed,      defaults.world_half_extent,    defaults.fixed_step_s,
          defaults.half_extent_min,  defaults.half_extent_max,      defaults.speed,
          defaults.gravity,          defaults.direction_interval_s, 0};
}

uint64_t HashFloat(uint64_t hash, float value) {
  return sweepstake::math::Fnv1aOfWord(hash, std::bit_cast<uint32_t>(value));
}

}  // namespace

struct swp_scene final : Handle<OwnScene> {
  using Handle::Handle;
};

uint32_t swp_scene_count(void) { return static_cast<uint32_t>(SceneNames().size()); }

// Returns the name's data without copying: the names are literals, so they end with NUL.
const char* swp_scene_name(uint32_t index) {
  const auto names = SceneNames();
  return index < names.size() ? names[index].data() : nullptr;
}

swp_result swp_scene_options_init(swp_scene_options* options) {
  return Give("swp_scene_options", DefaultSceneOptions(), options);
}

swp_result swp_scene_create(const char* scene, const swp_scene_options* options, swp_scene** out) {
  if (scene == nullptr || out == nullptr) return NullArgument("scene and out");
  return Guard([&] {
    swp_scene_options known = DefaultSceneOptions();
    swp_result wrong = TakeOptions("swp_scene_options", options, known);
    if (wrong == SWP_OK && known.reserved != 0) {
      wrong = Fail(SWP_INVALID_ARGUMENT, "reserved must be 0");
    }
    if (wrong != SWP_OK) return wrong;
    auto made = sweepstake::MakeScene(scene, ToSceneOptions(known));
    if (!made.ok()) return ToResult(made.status());
    Publish(std::make_unique<OwnScene>(OwnScene{std::move(*made)}), out);
    return kOk;
  });
}

void swp_scene_destroy(swp_scene* scene) { Destroy(scene); }

swp_result swp_scene_step(swp_scene* scene) {
  return Use(scene, [](OwnScene& live) { live.scene->Step(); });
}

swp_result swp_scene_boxes(const swp_scene* scene, const swp_aabb** boxes, uint32_t* count) {
  return Use(scene, [&](const OwnScene& live) {
    if (boxes == nullptr || count == nullptr) return NullArgument("boxes and count");
    const auto current = live.scene->aabbs();
    *boxes = reinterpret_cast<const swp_aabb*>(current.data());
    *count = static_cast<uint32_t>(current.size());
    return kOk;
  });
}

swp_result swp_scene_world(const swp_scene* scene, swp_aabb* world) {
  return Get(scene, "world", world,
             [](const OwnScene& live) { return std::bit_cast<swp_aabb>(live.scene->world()); });
}

swp_result swp_scene_frame_index(const swp_scene* scene, uint64_t* frame_index) {
  return Get(scene, "frame_index", frame_index,
             [](const OwnScene& live) { return live.scene->frame_index(); });
}

swp_result swp_scene_hash(const swp_scene* scene, uint64_t* hash) {
  return Get(scene, "hash", hash, [](const OwnScene& live) {
    uint64_t sum = sweepstake::math::kFnv1aStart;
    for (const Aabb& box : live.scene->aabbs()) {
      for (const float value : box.min) sum = HashFloat(sum, value);
      for (const float value : box.max) sum = HashFloat(sum, value);
    }
    return sum;
  });
}
