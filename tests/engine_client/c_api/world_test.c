/* Tests worlds: compares every backend with an independent brute-force search, and tests the rules
 * of buffers and call order. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

void test_version(void) {
  uint32_t major = 99;
  uint32_t minor = 99;
  uint32_t patch = 99;
  CHECK(swp_abi_version() == SWP_ABI_VERSION);
  CHECK(swp_abi_revision() == SWP_ABI_REVISION);
  CHECK_OK(swp_version(&major, &minor, &patch));
  CHECK(major < 99 && minor < 99 && patch < 99);
  CHECK(swp_struct_size(SWP_STRUCT_AABB) == sizeof(swp_aabb) && sizeof(swp_aabb) == 24);
  CHECK(swp_struct_size(SWP_STRUCT_PAIR) == sizeof(swp_pair));
  CHECK(swp_struct_size(SWP_STRUCT_COUNTERS) == sizeof(swp_counters));
  CHECK(swp_struct_size(SWP_STRUCT_SCENE_OPTIONS) == sizeof(swp_scene_options));
  CHECK(swp_struct_size(SWP_STRUCT_SESSION_OPTIONS) == sizeof(swp_session_options));
  CHECK(swp_struct_size(SWP_STRUCT_FRAME_SAMPLE) == sizeof(swp_frame_sample));
  CHECK(sizeof(swp_frame_sample) == 64);
  CHECK(swp_struct_size(SWP_STRUCT_SWITCH_COMMAND) == sizeof(swp_switch_command));
  CHECK(swp_struct_size(SWP_STRUCT_SWITCH_OUTCOME) == sizeof(swp_switch_outcome));
  CHECK(swp_struct_size(SWP_STRUCT_DECIDER_OPTIONS) == sizeof(swp_decider_options));
  CHECK(swp_struct_size(SWP_STRUCT_BELIEF) == sizeof(swp_belief));
  CHECK(swp_struct_size(SWP_STRUCT_EXECUTOR) == sizeof(swp_executor));
  CHECK(swp_struct_size(SWP_STRUCT_HOOKS) == sizeof(swp_hooks));
  CHECK(swp_struct_size(SWP_STRUCT_WORLD_OPTIONS) == sizeof(swp_world_options));
  CHECK(swp_struct_size(SWP_STRUCT_PROXIES_OPTIONS) == sizeof(swp_proxies_options));
  CHECK(swp_struct_size(SWP_STRUCT_FILTER) == sizeof(swp_filter));
  CHECK(swp_struct_size(SWP_STRUCT_PROXY_OPTIONS) == sizeof(swp_proxy_options));
  CHECK(swp_struct_size(SWP_STRUCT_PROXY_PAIR) == sizeof(swp_proxy_pair));
  CHECK(swp_struct_size(SWP_STRUCT_RAY) == sizeof(swp_ray));
  CHECK(swp_struct_size(SWP_STRUCT_RAY_HIT) == sizeof(swp_ray_hit));
  CHECK(swp_struct_size(SWP_STRUCT_SPHERE) == sizeof(swp_sphere));
  CHECK(swp_struct_size(SWP_STRUCT_BOX_SWEEP) == sizeof(swp_box_sweep));
  CHECK(swp_struct_size(SWP_STRUCT_SHADOW_STATS) == sizeof(swp_shadow_stats));
  CHECK(swp_struct_size(SWP_STRUCT_LINK_OPTIONS) == sizeof(swp_link_options));
  CHECK(swp_struct_size(SWP_STRUCT_LINK_STATS) == sizeof(swp_link_stats));
  CHECK(swp_struct_size(SWP_STRUCT_VERDICT) == sizeof(swp_verdict) && sizeof(swp_verdict) == 16);
  CHECK(swp_struct_size(0) == 0 && swp_struct_size(999) == 0);
}

/* Returns a copy of the world's pairs, which same_pairs may sort. */
static swp_pair* all_pairs(swp_world* world, uint64_t* count) {
  const swp_pair* found = NULL;
  CHECK_OK(swp_world_find_pairs(world));
  CHECK_OK(swp_world_pairs(world, &found, count));
  return copy_pairs(found, *count);
}

static void check_backend(const char* backend, const char* scene_name, uint32_t object_count) {
  swp_world* world = NULL;
  swp_scene* scene = make_scene(scene_name, object_count);
  CHECK_OK(swp_world_create(backend, NULL, &world));
  for (int frame = 0; frame < 12; ++frame) {
    const swp_aabb* boxes = NULL;
    uint32_t count = 0;
    uint64_t found_count = 0;
    uint64_t right_count = 0;
    swp_counters counters = {.struct_size = sizeof counters};
    CHECK_OK(swp_scene_boxes(scene, &boxes, &count));
    CHECK_OK(frame == 0 ? swp_world_build(world, boxes, count)
                        : swp_world_update(world, boxes, count));
    swp_pair* found = all_pairs(world, &found_count);
    swp_pair* right = brute_force(boxes, count, &right_count);
    CHECK(right_count > 0);
    CHECK(same_pairs(found, found_count, right, right_count));
    CHECK_OK(swp_world_counters(world, &counters));
    CHECK(counters.pair_count == right_count && counters.object_count == count);
    CHECK(counters.aabb_check_count > 0 && counters.native_bytes > 0);
    CHECK(counters.detection_time_ns > 0 && counters.backend_version > 0);
    free(found);
    free(right);
    CHECK_OK(swp_scene_step(scene));
  }
  swp_world_destroy(world);
  swp_scene_destroy(scene);
}

void test_worlds(void) {
  CHECK(swp_backend_count() == 7);
  for (uint32_t i = 0; i < swp_backend_count(); ++i) {
    check_backend(swp_backend_name(i), "suite-b", 500);
    check_backend(swp_backend_name(i), "hurricane", 700);
  }
}

static const swp_aabb kBoxes[3] = {
    {{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}, {{0.5F, 0.5F, 0.5F}, {3, 3, 3}}};

/* The pairs are found once, and stay in place until the next boxes. */
static void check_that_pairs_stay(swp_world* world) {
  const swp_pair* pairs = NULL;
  const swp_pair* again = NULL;
  uint64_t count = 7;
  CHECK_OK(swp_world_build(world, kBoxes, 3));
  CHECK(swp_world_pairs(world, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK(pairs == NULL && count == 7);
  CHECK_OK(swp_world_find_pairs(world));
  CHECK_OK(swp_world_pairs(world, &pairs, &count));
  CHECK_OK(swp_world_find_pairs(world));
  CHECK_OK(swp_world_pairs(world, &again, &count));
  CHECK(count == 3 && pairs == again);
  uint64_t right_count = 0;
  swp_pair* right = brute_force(kBoxes, 3, &right_count);
  swp_pair* copy = copy_pairs(pairs, count);
  CHECK(same_pairs(copy, count, right, right_count));
  free(copy);
  free(right);
}

/* Invalid boxes have no pairs, and are counted. */
static void check_broken_boxes(swp_world* world) {
  const swp_aabb boxes[5] = {{{0, 0, 0}, {1, 1, 1}},
                             {{0, NAN, 0}, {1, 1, 1}},
                             {{1, 0, 0}, {0, 1, 1}},
                             {{-INFINITY, 0, 0}, {1, 1, 1}},
                             {{0, 0, 0}, {1, INFINITY, 1}}};
  swp_counters counters = {.struct_size = sizeof counters};
  uint64_t count = 99;
  CHECK_OK(swp_world_build(world, boxes, 4));
  free(all_pairs(world, &count));
  CHECK(count == 0);
  CHECK_OK(swp_world_counters(world, &counters));
  CHECK(counters.invalid_box_count == 3);
  CHECK_OK(swp_world_update(world, boxes, 5));
  free(all_pairs(world, &count));
  CHECK(count == 0);
  CHECK_OK(swp_world_counters(world, &counters));
  CHECK(counters.invalid_box_count == 4);
}

/* A search with more pairs than max_pairs fails, and the next build makes the world usable again.
 */
static void check_max_pairs(const char* backend) {
  enum { kCount = 2000 };
  static swp_aabb boxes[kCount];
  swp_world_options options = {.struct_size = sizeof options};
  swp_counters counters = {.struct_size = sizeof counters};
  const swp_pair* pairs = NULL;
  swp_world* world = NULL;
  uint64_t count = 0;
  for (int i = 0; i < kCount; ++i) boxes[i] = (swp_aabb){{0, 0, 0}, {1, 1, 1}};
  CHECK_OK(swp_world_options_init(&options));
  CHECK(options.max_pairs == 0);
  options.max_pairs = 3;
  CHECK_OK(swp_world_create(backend, &options, &world));
  CHECK_OK(swp_world_build(world, boxes, kCount));
  CHECK(swp_world_find_pairs(world) == SWP_RESOURCE_EXHAUSTED);
  CHECK(strstr(swp_last_error(), "max_pairs") != NULL);
  CHECK(swp_world_pairs(world, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK(swp_world_update(world, kBoxes, 3) == SWP_FAILED_PRECONDITION);
  CHECK(swp_world_find_pairs(world) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_world_counters(world, &counters));
  CHECK(counters.pair_count == 0 && counters.native_bytes < (uint64_t)8 * 1024 * 1024);
  check_that_pairs_stay(world); /* of 3 boxes, which have 3 pairs */
  swp_world_destroy(world);
}

void test_world_rules(void) {
  for (uint32_t i = 0; i < swp_backend_count(); ++i) {
    swp_world* world = NULL;
    uint64_t count = 5;
    CHECK_OK(swp_world_create(swp_backend_name(i), NULL, &world));
    CHECK(swp_world_update(world, kBoxes, 3) == SWP_FAILED_PRECONDITION);
    CHECK(swp_world_find_pairs(world) == SWP_FAILED_PRECONDITION);
    CHECK_OK(swp_world_build(world, NULL, 0));
    free(all_pairs(world, &count));
    CHECK(count == 0);
    check_that_pairs_stay(world);
    CHECK_OK(swp_world_update(world, kBoxes, 2));
    CHECK_OK(swp_world_update(world, kBoxes, 3));
    check_broken_boxes(world);
    swp_world_destroy(world);
    check_max_pairs(swp_backend_name(i));
  }
  CHECK(swp_backend_name(swp_backend_count()) == NULL);
}
