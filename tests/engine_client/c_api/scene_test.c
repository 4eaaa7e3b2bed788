/* Tests scenes: equal seeds give equal motion, other seeds do not; errors list the valid values. */
#include <string.h>

#include "tests/engine_client/c_api/check.h"

static uint64_t hash_after(const char* name, uint64_t seed, int steps) {
  swp_scene_options options = {.struct_size = sizeof options};
  swp_scene* scene = NULL;
  uint64_t hash = 0;
  uint64_t frame_index = 99;
  CHECK_OK(swp_scene_options_init(&options));
  options.object_count = 100;
  options.spawn_seed = seed;
  options.motion_seed = seed;
  CHECK_OK(swp_scene_create(name, &options, &scene));
  for (int i = 0; i < steps; ++i) CHECK_OK(swp_scene_step(scene));
  CHECK_OK(swp_scene_frame_index(scene, &frame_index));
  CHECK(frame_index == (uint64_t)steps);
  CHECK_OK(swp_scene_hash(scene, &hash));
  swp_scene_destroy(scene);
  return hash;
}

static void check_boxes(void) {
  swp_scene* scene = make_scene("free-fall", 50);
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  swp_aabb world;
  CHECK_OK(swp_scene_boxes(scene, &boxes, &count));
  CHECK(count == 50 && boxes != NULL);
  CHECK_OK(swp_scene_world(scene, &world));
  CHECK(world.min[0] < world.max[0]);
  swp_scene_destroy(scene);
}

void test_scenes(void) {
  CHECK(swp_scene_count() == 40);
  CHECK(swp_scene_name(swp_scene_count()) == NULL);
  CHECK(strcmp(swp_scene_name(0), "brownian") == 0);
  for (uint32_t i = 0; i < 5; ++i) {
    const char* name = swp_scene_name(i);
    const uint64_t hash = hash_after(name, 1, 30);
    CHECK(hash == hash_after(name, 1, 30));
    CHECK(hash != hash_after(name, 1, 31));
    CHECK(hash != hash_after(name, 2, 30));
  }
  check_boxes();
  swp_scene* scene = NULL;
  CHECK(swp_scene_create("nowhere", NULL, &scene) == SWP_NOT_FOUND);
  CHECK(strstr(swp_last_error(), "hurricane") != NULL && scene == NULL);
  for (uint32_t i = 0; i < swp_scene_count(); ++i) {
    CHECK_OK(swp_scene_create(swp_scene_name(i), NULL, &scene));
    swp_scene_destroy(scene);
  }
  CHECK_OK(swp_scene_create("waves", NULL, &scene));
  swp_scene_destroy(scene);
}
