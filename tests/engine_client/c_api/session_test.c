/* Tests sessions: the frame path, its queue and its shadow lane. */
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

enum { kObjects = 300, kFrameNs = 5000000 };

/* Runs one frame of `scene`; the pairs must equal those of brute force. */
static void run_frame(swp_session* session, swp_scene* scene) {
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  uint64_t found_count = 0;
  const swp_pair* found = NULL;
  CHECK_OK(swp_scene_boxes(scene, &boxes, &count));
  CHECK_OK(swp_session_begin_frame(session));
  CHECK_OK(swp_session_find_pairs(session, boxes, count));
  CHECK_OK(swp_session_pairs(session, &found, &found_count));
  swp_pair* pairs = copy_pairs(found, found_count);
  uint64_t right_count = 0;
  swp_pair* right = brute_force(boxes, count, &right_count);
  CHECK(same_pairs(pairs, found_count, right, right_count));
  free(pairs);
  free(right);
  CHECK_OK(swp_session_end_frame(session, kFrameNs, 0));
  CHECK_OK(swp_scene_step(scene));
}

static swp_session* make_session(uint32_t queue_frames) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_options_init(&options));
  options.queue_frames = queue_frames;
  options.shadow = SWP_SHADOW_OFF;
  options.settling_ns = 2 * kFrameNs;
  CHECK_OK(swp_session_create(&options, &session));
  return session;
}

static void check_arms(const swp_session* session) {
  uint32_t count = 0;
  CHECK_OK(swp_session_arm_count(session, &count));
  CHECK(count == swp_backend_count());
  for (uint32_t i = 0; i < count; ++i) {
    const char* name = NULL;
    uint32_t version = 0;
    CHECK_OK(swp_session_arm_name(session, i, &name));
    CHECK(strcmp(name, swp_backend_name(i)) == 0);
    CHECK_OK(swp_session_arm_version(session, i, &version));
    CHECK(version > 0);
  }
}

static void check_order(swp_session* session) {
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_end_frame(session, 1, 0) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_find_pairs(session, &box, 1) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_session_begin_frame(session));
  CHECK(swp_session_begin_frame(session) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_session_find_pairs(session, &box, 1));
  CHECK(swp_session_find_pairs(session, NULL, 4) == SWP_INVALID_ARGUMENT);
  CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_end_frame(session, 1, SWP_FRAME_REBUILD) == SWP_INVALID_ARGUMENT);
  CHECK_OK(swp_session_end_frame(session, 1, SWP_FRAME_PAUSED));
  CHECK(swp_session_find_pairs(session, &box, 1) == SWP_FAILED_PRECONDITION);
}

/* Two searches in a frame give one sample; the pairs are those of the second search. */
static void check_substeps(swp_session* session) {
  const swp_aabb boxes[3] = {
      {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}};
  swp_frame_sample before;
  swp_frame_sample sample;
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  CHECK_OK(swp_session_last_sample(session, &before));
  CHECK_OK(swp_session_begin_frame(session));
  CHECK_OK(swp_session_find_pairs(session, boxes, 3));
  CHECK_OK(swp_session_pairs(session, &pairs, &count));
  CHECK(count == 3);
  CHECK_OK(swp_session_find_pairs(session, boxes, 2));
  CHECK_OK(swp_session_pairs(session, &pairs, &count));
  CHECK(count == 1 && pairs[0].a == 0 && pairs[0].b == 1);
  CHECK_OK(swp_session_end_frame(session, 1, 0));
  CHECK_OK(swp_session_last_sample(session, &sample));
  CHECK(sample.frame_index == before.frame_index + 1);
  CHECK(sample.pair_count == 1 && sample.object_count == 2);
}

/* A search with more pairs than max_pairs fails; the next frame works. */
static void check_max_pairs(swp_scene* scene) {
  enum { kCount = 500 };
  swp_aabb boxes[kCount];
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  swp_frame_sample sample;
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  for (int i = 0; i < kCount; ++i) boxes[i] = (swp_aabb){{0, 0, 0}, {1, 1, 1}};
  CHECK_OK(swp_session_options_init(&options));
  options.mode = SWP_MODE_MANUAL;
  options.max_pairs = 100000;
  CHECK_OK(swp_session_create(&options, &session));
  run_frame(session, scene);
  CHECK_OK(swp_session_begin_frame(session));
  CHECK(swp_session_find_pairs(session, boxes, kCount) == SWP_RESOURCE_EXHAUSTED);
  CHECK(strstr(swp_last_error(), "max_pairs") != NULL);
  CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_session_end_frame(session, kFrameNs, 0));
  CHECK_OK(swp_session_last_sample(session, &sample));
  CHECK(sample.flags == SWP_FRAME_PAIRS_EXCEEDED);
  run_frame(session, scene);
  CHECK_OK(swp_session_last_sample(session, &sample));
  CHECK(sample.flags == SWP_FRAME_REBUILD);
  swp_session_destroy(session);
}

/* Sorted pairs equal those of brute force byte by byte with every arm. */
static void check_sorted_pairs(swp_scene* scene) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_options_init(&options));
  options.mode = SWP_MODE_MANUAL;
  options.sorted_pairs = 1;
  options.thread_count = 2;
  CHECK_OK(swp_session_create(&options, &session));
  for (uint32_t frame = 0; frame < 3 * swp_backend_count(); ++frame) {
    const swp_aabb* boxes = NULL;
    uint32_t count = 0;
    uint64_t found_count = 0;
    uint64_t right_count = 0;
    const swp_pair* found = NULL;
    CHECK_OK(swp_session_select_arm(session, swp_backend_name(frame % swp_backend_count())));
    CHECK_OK(swp_scene_boxes(scene, &boxes, &count));
    CHECK_OK(swp_session_begin_frame(session));
    CHECK_OK(swp_session_find_pairs(session, boxes, count));
    CHECK_OK(swp_session_end_frame(session, kFrameNs, 0));
    CHECK_OK(swp_session_pairs(session, &found, &found_count));
    swp_pair* right = brute_force(boxes, count, &right_count);
    CHECK(found_count == right_count && memcmp(found, right, right_count * sizeof *right) == 0);
    free(right);
    CHECK_OK(swp_scene_step(scene));
  }
  swp_session_destroy(session);
}

/* Selects every arm in turn in manual mode. */
static void check_selection(swp_session* session, swp_scene* scene) {
  swp_mode mode = 0;
  CHECK_OK(swp_session_set_mode(session, SWP_MODE_MANUAL));
  CHECK_OK(swp_session_mode(session, &mode));
  CHECK(mode == SWP_MODE_MANUAL);
  for (uint32_t i = 1; i < swp_backend_count(); ++i) {
    uint32_t arm = 99;
    uint32_t epoch = 99;
    swp_frame_sample sample;
    CHECK_OK(swp_session_select_arm(session, swp_backend_name(i)));
    run_frame(session, scene);
    CHECK_OK(swp_session_active_arm(session, &arm));
    CHECK_OK(swp_session_switch_epoch(session, &epoch));
    CHECK(arm == i && epoch == i);
    CHECK_OK(swp_session_last_sample(session, &sample));
    CHECK(sample.arm == i && sample.switch_epoch == i && sample.object_count == kObjects);
    CHECK(sample.flags == SWP_FRAME_REBUILD && sample.frame_time_ns == kFrameNs);
    CHECK(sample.detection_time_ns > 0 && sample.pair_count > 0 && sample.native_bytes > 0);
  }
  CHECK(swp_session_select_arm(session, "Octree") == SWP_NOT_FOUND);
  CHECK(strstr(swp_last_error(), "KDTree") != NULL);
}

void test_frames(void) {
  swp_session* session = make_session(64);
  swp_scene* scene = make_scene("suite-h", kObjects);
  check_arms(session);
  check_order(session);
  check_substeps(session);
  check_selection(session, scene);
  check_sorted_pairs(scene);
  check_max_pairs(scene);
  swp_session_destroy(session);
  swp_scene_destroy(scene);
}

static void check_bail_out_limit(swp_scene* scene) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  swp_frame_sample sample;
  CHECK_OK(swp_session_options_init(&options));
  options.bail_out_ns = 1; /* every frame takes longer */
  CHECK_OK(swp_session_create(&options, &session));
  run_frame(session, scene);
  CHECK_OK(swp_session_last_sample(session, &sample));
  CHECK((sample.flags & SWP_FRAME_BAIL_OUT) != 0);
  swp_session_destroy(session);
}

/* If nothing reads the samples, the oldest are dropped and counted. */
static void check_full_queue(swp_session* session, swp_scene* scene) {
  uint64_t dropped = 99;
  uint64_t dropped_notes = 99;
  for (int i = 0; i < 20; ++i) run_frame(session, scene);
  CHECK_OK(swp_session_dropped(session, &dropped, &dropped_notes));
  CHECK(dropped == 4 && dropped_notes == 0);
}

/* The lane is automatic by default. When it is on, it soon visits every arm. */
static void check_shadow_lane(swp_scene* scene) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = make_session(16);
  swp_shadow_stats stats = {.struct_size = sizeof stats};
  CHECK_OK(swp_session_shadow_stats(session, &stats));
  CHECK(stats.state == SWP_SHADOW_STATE_OFF && stats.visit_count == 0);
  swp_session_destroy(session);
  CHECK_OK(swp_session_create(NULL, &session));
  CHECK_OK(swp_session_shadow_stats(session, &stats));
  CHECK(stats.state == SWP_SHADOW_STATE_RUNNING || stats.state == SWP_SHADOW_STATE_NO_SPARE_CORE);
  swp_session_destroy(session);
  CHECK_OK(swp_session_options_init(&options));
  options.mode = 0;
  CHECK(swp_session_create(&options, &session) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "call swp_session_options_init") != NULL);
  options.mode = SWP_MODE_MANUAL;
  options.shadow = 3;
  CHECK(swp_session_create(&options, &session) == SWP_INVALID_ARGUMENT);
  options.shadow = SWP_SHADOW_ON;
  CHECK_OK(swp_session_create(&options, &session));
  CHECK_OK(swp_session_shadow_stats(session, &stats));
  if (stats.state == SWP_SHADOW_STATE_RUNNING) {
    for (int i = 0; i < 1000000 && stats.visit_count < swp_backend_count(); ++i) {
      run_frame(session, scene);
      CHECK_OK(swp_session_shadow_stats(session, &stats));
    }
    CHECK(stats.visit_count >= swp_backend_count() && stats.copied_frame_count >= 4);
  } else {
    CHECK(stats.state == SWP_SHADOW_STATE_NO_SPARE_CORE);
  }
  swp_session_destroy(session);
}

/* A lane with too little memory reports why it does nothing. */
static void check_shadow_memory(swp_scene* scene) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  swp_shadow_stats stats = {.struct_size = sizeof stats};
  CHECK_OK(swp_session_options_init(&options));
  CHECK(options.shadow_duty_ratio == 0.15 && options.shadow_memory_bytes == 64 * 1024 * 1024);
  options.shadow = SWP_SHADOW_AUTO;
  options.shadow_duty_ratio = 1;
  options.shadow_memory_bytes = 1000;
  CHECK_OK(swp_session_create(&options, &session));
  CHECK_OK(swp_session_shadow_stats(session, &stats));
  for (int i = 0; i < 1000000 && stats.state == SWP_SHADOW_STATE_RUNNING; ++i) {
    run_frame(session, scene);
    CHECK_OK(swp_session_shadow_stats(session, &stats));
  }
  CHECK(stats.state == SWP_SHADOW_STATE_TOO_BIG || stats.state == SWP_SHADOW_STATE_NO_SPARE_CORE);
  swp_session_destroy(session);
}

void test_queue(void) {
  swp_session* session = make_session(16);
  swp_scene* scene = make_scene("suite-b", kObjects);
  check_full_queue(session, scene);
  check_bail_out_limit(scene);
  check_shadow_lane(scene);
  check_shadow_memory(scene);
  swp_session_destroy(session);
  swp_scene_destroy(scene);
}
