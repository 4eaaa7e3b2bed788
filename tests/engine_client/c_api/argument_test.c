/* NULL and invalid values for every argument give SWP_INVALID_ARGUMENT and a message, and change
 * nothing. */
#include <math.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

static void check_worlds(void) {
  swp_world* world = NULL;
  swp_world* none = NULL;
  swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  swp_counters counters = {.struct_size = sizeof counters};
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  REFUSED(swp_world_create(NULL, NULL, &none));
  REFUSED(swp_world_create("SAP", NULL, NULL));
  CHECK(swp_world_create("Octree", NULL, &none) == SWP_NOT_FOUND && none == NULL);
  CHECK(strstr(swp_last_error(), "KDTree") != NULL);
  CHECK_OK(swp_world_create("SAP", NULL, &world));
  REFUSED(swp_world_build(NULL, &box, 1));
  REFUSED(swp_world_build(world, NULL, 1));
  REFUSED(swp_world_build(world, &box, 0x80000000U));
  REFUSED(swp_world_update(NULL, &box, 1));
  REFUSED(swp_world_update(world, NULL, 1));
  REFUSED(swp_world_find_pairs(NULL));
  CHECK_OK(swp_world_build(world, &box, 1));
  CHECK_OK(swp_world_find_pairs(world));
  REFUSED(swp_world_pairs(NULL, &pairs, &count));
  REFUSED(swp_world_pairs(world, NULL, &count));
  REFUSED(swp_world_pairs(world, &pairs, NULL));
  REFUSED(swp_world_counters(NULL, &counters));
  REFUSED(swp_world_counters(world, NULL));
  swp_world_destroy(world);
  swp_world_destroy(NULL);
}

static void check_scene_options(void) {
  swp_scene_options options = {.struct_size = sizeof options};
  swp_scene* scene = NULL;
  REFUSED(swp_scene_options_init(NULL));
  CHECK_OK(swp_scene_options_init(&options));
  options.reserved = 1;
  REFUSED(swp_scene_create("brownian", &options, &scene));
  CHECK_OK(swp_scene_options_init(&options));
  options.fixed_step_s = -1;
  REFUSED(swp_scene_create("brownian", &options, &scene));
  CHECK(scene == NULL);
}

static void check_scenes(void) {
  swp_scene* scene = make_scene("brownian", 3);
  const swp_aabb* boxes = NULL;
  swp_aabb world;
  uint32_t count = 0;
  uint64_t number = 0;
  check_scene_options();
  REFUSED(swp_scene_create(NULL, NULL, &scene));
  REFUSED(swp_scene_create("brownian", NULL, NULL));
  REFUSED(swp_scene_step(NULL));
  REFUSED(swp_scene_boxes(NULL, &boxes, &count));
  REFUSED(swp_scene_boxes(scene, NULL, &count));
  REFUSED(swp_scene_boxes(scene, &boxes, NULL));
  REFUSED(swp_scene_world(NULL, &world));
  REFUSED(swp_scene_world(scene, NULL));
  REFUSED(swp_scene_frame_index(NULL, &number));
  REFUSED(swp_scene_frame_index(scene, NULL));
  REFUSED(swp_scene_hash(NULL, &number));
  REFUSED(swp_scene_hash(scene, NULL));
  swp_scene_destroy(scene);
  swp_scene_destroy(NULL);
}

static void run_nothing(void* user, uint64_t part_count, swp_run_part run_part, void* job) {
  (void)user;
  for (uint64_t part = 0; part < part_count; ++part) run_part(job, part);
}

static void check_executors(void) {
  swp_executor executor = {.struct_size = sizeof executor};
  swp_world_options options = {.struct_size = sizeof options};
  swp_world* world = NULL;
  REFUSED(swp_executor_init(NULL));
  REFUSED(swp_world_options_init(NULL));
  REFUSED(swp_world_create("SAP", NULL, NULL));
#define WITH(statement)                                 \
  do {                                                  \
    CHECK_OK(swp_executor_init(&executor));             \
    CHECK_OK(swp_world_options_init(&options));         \
    executor.run_parts = run_nothing;                   \
    options.executor = &executor;                       \
    statement;                                          \
    REFUSED(swp_world_create("SAP", &options, &world)); \
  } while (0)
  WITH(executor.run_parts = NULL);
  WITH(executor.thread_count = 0);
  WITH(executor.thread_count = 257);
  WITH(options.thread_count = 2);
  WITH(options.thread_count = 257);
  WITH(options.sorted_pairs = 2);
  WITH(options.reserved = 1);
#undef WITH
  CHECK(world == NULL);
}

static void check_proxies_options(void) {
  swp_proxies_options options = {.struct_size = sizeof options};
  swp_proxies* proxies = NULL;
  REFUSED(swp_proxies_options_init(NULL));
  REFUSED(swp_proxies_create(NULL, NULL));
#define WITH(field, value)                           \
  do {                                               \
    CHECK_OK(swp_proxies_options_init(&options));    \
    options.field = (value);                         \
    REFUSED(swp_proxies_create(&options, &proxies)); \
  } while (0)
  WITH(pair_events, 2);
  WITH(sorted_pairs, 2);
  WITH(thread_count, 257);
  WITH(event_margin, -1.0F);
  WITH(reserved, 1);
#undef WITH
  CHECK(proxies == NULL);
}

/* A refused shape leaves all outputs unchanged. */
static void check_refused_shapes(const swp_proxies* proxies) {
  const swp_sphere spheres[2] = {{{0, 0, 0}, 1}, {{0, 0, 0}, -1}};
  const swp_box_sweep sweeps[2] = {{{{0, 0, 0}, {1, 1, 1}}, {1, 0, 0}},
                                   {{{0, 0, 0}, {1, 1, 1}}, {NAN, 0, 0}}};
  swp_proxy found = 9;
  swp_ray_hit hits[2] = {{9, 9, 9}, {9, 9, 9}};
  uint64_t ends[2] = {9, 9};
  CHECK(swp_proxies_query_spheres(proxies, spheres, 2, NULL, &found, 1, ends) ==
        SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "sphere 1: ") != NULL);
  CHECK(found == 9 && ends[0] == 9);
  CHECK(swp_proxies_sweep_boxes(proxies, sweeps, 2, NULL, hits) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "sweep 1: ") != NULL);
  CHECK(hits[0].proxy == 9 && hits[0].distance == 9);
}

/* Queries without a shape also require swp_proxies_prepare_queries. */
static void check_unprepared(const swp_proxies* proxies) {
  CHECK(swp_proxies_query_boxes(proxies, NULL, 0, NULL, NULL, 0, NULL) == SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_query_spheres(proxies, NULL, 0, NULL, NULL, 0, NULL) ==
        SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_cast_rays(proxies, NULL, 0, NULL, NULL) == SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_sweep_boxes(proxies, NULL, 0, NULL, NULL) == SWP_FAILED_PRECONDITION);
}

static void check_many_shapes(void) {
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  swp_proxy added = 0;
  swp_proxies* proxies = NULL;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  CHECK_OK(swp_proxies_add_many(proxies, &box, NULL, 1, &added));
  check_unprepared(proxies);
  CHECK_OK(swp_proxies_prepare_queries(proxies));
  check_refused_shapes(proxies);
  swp_proxies_destroy(proxies);
}

static void check_proxies_without_one(void) {
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  const swp_aabb* boxes = NULL;
  const swp_ray ray = {{0, 0, 0}, {1, 0, 0}, 1};
  const swp_sphere sphere = {{0, 0, 0}, 1};
  const swp_box_sweep sweep = {{{0, 0, 0}, {1, 1, 1}}, {1, 0, 0}};
  const double corner[3] = {0, 0, 0};
  swp_aabb rounded;
  const swp_pair* pairs = NULL;
  const swp_proxy_pair* events = NULL;
  swp_proxy proxy = UINT64_C(1) << 32;
  swp_ray_hit hit;
  uint64_t count = 0;
  uint32_t number = 0;
  REFUSED(swp_proxies_add_many(NULL, &box, NULL, 1, &proxy));
  REFUSED(swp_proxies_remove_many(NULL, &proxy, 1));
  REFUSED(swp_proxies_set_boxes(NULL, &proxy, &box, 1));
  REFUSED(swp_proxies_set_filter(NULL, proxy, NULL));
  REFUSED(swp_proxies_set_user(NULL, proxy, 1));
  REFUSED(swp_proxies_get(NULL, proxy, NULL, NULL));
  REFUSED(swp_proxies_handle(NULL, 0, &proxy));
  REFUSED(swp_proxies_counts(NULL, &number, &number, &count));
  REFUSED(swp_proxies_moving_boxes(NULL, &boxes, &number));
  REFUSED(swp_proxies_resolve(NULL, NULL, 0));
  REFUSED(swp_proxies_pairs(NULL, &pairs, &count));
  REFUSED(swp_proxies_added(NULL, &events, &count));
  REFUSED(swp_proxies_removed(NULL, &events, &count));
  REFUSED(swp_proxies_prepare_queries(NULL));
  REFUSED(swp_proxies_query_boxes(NULL, &box, 1, NULL, &proxy, 1, &count));
  REFUSED(swp_proxies_cast_rays(NULL, &ray, 1, NULL, &hit));
  REFUSED(swp_proxies_cast_ray(NULL, &ray, NULL, &hit, 1, &count));
  REFUSED(swp_proxies_set_static(NULL, proxy, 1));
  REFUSED(swp_proxies_set_sleeping(NULL, proxy, 1));
  REFUSED(swp_proxies_shift_origin(NULL, box.min));
  REFUSED(swp_proxies_snapshot_bytes(NULL, &count));
  REFUSED(swp_proxies_save(NULL, &rounded, sizeof rounded));
  REFUSED(swp_proxies_restore(NULL, &box, sizeof box));
  REFUSED(swp_proxies_query_spheres(NULL, &sphere, 1, NULL, &proxy, 1, &count));
  REFUSED(swp_proxies_sweep_boxes(NULL, &sweep, 1, NULL, &hit));
  REFUSED(swp_round_outward(NULL, corner, &rounded));
  REFUSED(swp_round_outward(corner, NULL, &rounded));
  REFUSED(swp_round_outward(corner, corner, NULL));
  swp_proxies_destroy(NULL);
}

static void check_adding(swp_proxies* proxies) {
  const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
  const swp_proxy_options unknown_flag[2] = {{{1, 1}, 0, 0, 0}, {{1, 1}, 2, 0, 0}};
  const swp_proxy_options reserved[2] = {{{1, 1}, 0, 0, 0}, {{1, 1}, 0, 1, 0}};
  swp_proxy added[2] = {77, 77};
  uint32_t count = 99;
  REFUSED(swp_proxies_add_many(proxies, NULL, NULL, 1, added));
  REFUSED(swp_proxies_add_many(proxies, boxes, NULL, 1, NULL));
  REFUSED(swp_proxies_add_many(proxies, boxes, unknown_flag, 2, added));
  REFUSED(swp_proxies_add_many(proxies, boxes, reserved, 2, added));
  CHECK_OK(swp_proxies_add_many(proxies, NULL, NULL, 0, NULL));
  REFUSED(swp_proxies_remove_many(proxies, NULL, 1));
  REFUSED(swp_proxies_set_boxes(proxies, NULL, boxes, 1));
  REFUSED(swp_proxies_set_boxes(proxies, added, NULL, 1));
  CHECK_OK(swp_proxies_set_boxes(proxies, NULL, NULL, 0));
  CHECK_OK(swp_proxies_remove_many(proxies, NULL, 0));
  CHECK_OK(swp_proxies_counts(proxies, &count, NULL, NULL));
  CHECK(count == 0 && added[0] == 77);
}

static void check_queries(swp_proxies* proxies) {
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  const swp_ray ray = {{0, 0, 0}, {1, 0, 0}, 1};
  const swp_ray backwards = {{0, 0, 0}, {1, 0, 0}, -1};
  swp_proxy proxy = 0;
  swp_ray_hit hit;
  uint64_t count = 0;
  CHECK_OK(swp_proxies_prepare_queries(proxies));
  REFUSED(swp_proxies_query_boxes(proxies, NULL, 1, NULL, &proxy, 1, &count));
  REFUSED(swp_proxies_query_boxes(proxies, &box, 1, NULL, NULL, 1, &count));
  REFUSED(swp_proxies_query_boxes(proxies, &box, 1, NULL, &proxy, 1, NULL));
  CHECK_OK(swp_proxies_query_boxes(proxies, NULL, 0, NULL, NULL, 0, NULL));
  REFUSED(swp_proxies_cast_rays(proxies, NULL, 1, NULL, &hit));
  REFUSED(swp_proxies_cast_rays(proxies, &ray, 1, NULL, NULL));
  REFUSED(swp_proxies_cast_rays(proxies, &backwards, 1, NULL, &hit));
  CHECK_OK(swp_proxies_cast_rays(proxies, NULL, 0, NULL, NULL));
  REFUSED(swp_proxies_cast_ray(proxies, NULL, NULL, &hit, 1, &count));
  REFUSED(swp_proxies_cast_ray(proxies, &backwards, NULL, &hit, 1, &count));
  REFUSED(swp_proxies_cast_ray(proxies, &ray, NULL, NULL, 1, &count));
  REFUSED(swp_proxies_cast_ray(proxies, &ray, NULL, &hit, 1, NULL));
}

static void check_shapes(swp_proxies* proxies) {
  const swp_sphere spheres[2] = {{{0, 0, 0}, 1}, {{0, 0, 0}, -1}};
  const swp_box_sweep sweeps[2] = {{{{0, 0, 0}, {1, 1, 1}}, {1, 0, 0}},
                                   {{{1, 0, 0}, {0, 1, 1}}, {1, 0, 0}}};
  swp_proxy proxy = 0;
  swp_ray_hit hit;
  uint64_t count = 0;
  REFUSED(swp_proxies_query_spheres(proxies, NULL, 1, NULL, &proxy, 1, &count));
  REFUSED(swp_proxies_query_spheres(proxies, spheres, 1, NULL, NULL, 1, &count));
  REFUSED(swp_proxies_query_spheres(proxies, spheres, 1, NULL, &proxy, 1, NULL));
  REFUSED(swp_proxies_query_spheres(proxies, spheres + 1, 1, NULL, &proxy, 1, &count));
  CHECK_OK(swp_proxies_query_spheres(proxies, NULL, 0, NULL, NULL, 0, NULL));
  REFUSED(swp_proxies_sweep_boxes(proxies, NULL, 1, NULL, &hit));
  REFUSED(swp_proxies_sweep_boxes(proxies, sweeps, 1, NULL, NULL));
  REFUSED(swp_proxies_sweep_boxes(proxies, sweeps + 1, 1, NULL, &hit));
  CHECK_OK(swp_proxies_sweep_boxes(proxies, NULL, 0, NULL, NULL));
}

static void check_states(swp_proxies* proxies, swp_proxy proxy) {
  uint64_t too_short = 0;
  const float nowhere[3] = {0, INFINITY, 0};
  REFUSED(swp_proxies_set_static(proxies, proxy, 2));
  REFUSED(swp_proxies_set_sleeping(proxies, proxy, 2));
  REFUSED(swp_proxies_shift_origin(proxies, NULL));
  REFUSED(swp_proxies_shift_origin(proxies, nowhere));
  REFUSED(swp_proxies_snapshot_bytes(proxies, NULL));
  REFUSED(swp_proxies_save(proxies, NULL, 1));
  REFUSED(swp_proxies_save(proxies, &too_short, sizeof too_short));
  REFUSED(swp_proxies_restore(proxies, NULL, 1));
}

static void check_proxies(void) {
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  const swp_aabb* boxes = NULL;
  const swp_pair wrong[4] = {{0, 1}, {0, 0}, {1, 0}, {0, 0x80000000U}};
  const swp_pair* pairs = NULL;
  const swp_proxy_pair* events = NULL;
  swp_proxies* proxies = NULL;
  swp_proxy proxy = 0;
  uint64_t count = 0;
  uint32_t number = 0;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  check_adding(proxies);
  REFUSED(swp_proxies_handle(proxies, 0, NULL));
  CHECK_OK(swp_proxies_counts(proxies, NULL, NULL, NULL));
  REFUSED(swp_proxies_moving_boxes(proxies, NULL, &number));
  REFUSED(swp_proxies_moving_boxes(proxies, &boxes, NULL));
  CHECK_OK(swp_proxies_add_many(proxies, &box, NULL, 1, &proxy));
  for (int i = 0; i < 4; ++i) REFUSED(swp_proxies_resolve(proxies, &wrong[i], 1));
  REFUSED(swp_proxies_resolve(proxies, NULL, 1));
  check_states(proxies, proxy);
  CHECK_OK(swp_proxies_resolve(proxies, NULL, 0));
  REFUSED(swp_proxies_pairs(proxies, NULL, &count));
  REFUSED(swp_proxies_pairs(proxies, &pairs, NULL));
  REFUSED(swp_proxies_added(proxies, NULL, &count));
  REFUSED(swp_proxies_added(proxies, &events, NULL));
  REFUSED(swp_proxies_removed(proxies, NULL, &count));
  REFUSED(swp_proxies_removed(proxies, &events, NULL));
  check_queries(proxies);
  check_shapes(proxies);
  swp_proxies_destroy(proxies);
}

static void check_session_options(void) {
  char many[32 * 4 + 4] = "SAP";
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  REFUSED(swp_session_options_init(NULL));
  REFUSED(swp_session_create(NULL, NULL));
#define WITH(field, value)                           \
  do {                                               \
    CHECK_OK(swp_session_options_init(&options));    \
    options.field = (value);                         \
    REFUSED(swp_session_create(&options, &session)); \
  } while (0)
  WITH(arms, "SAP,SAP");
  WITH(arms, ",");
  WITH(mode, 0);
  WITH(mode, 3);
  WITH(queue_frames, 0);
  WITH(queue_frames, 1);
  WITH(queue_frames, 100);
  WITH(queue_frames, 1U << 21);
  WITH(bail_out_ns, 0);
  WITH(thread_count, 257);
  WITH(sorted_pairs, 2);
  WITH(shadow_duty_ratio, 0);
  WITH(shadow_duty_ratio, 1.5);
  for (int i = 1; i <= 32; ++i) strcat(many, ",SAP");
  WITH(arms, many);
#undef WITH
  CHECK_OK(swp_session_options_init(&options));
  for (int i = 0; i < 4; ++i) {
    static const char* const unknown[4] = {"Octree", ",SAP", "SAP,", "SAP, DBVT"};
    options.arms = unknown[i];
    CHECK(swp_session_create(&options, &session) == SWP_NOT_FOUND);
  }
  options.arms = "SAP";
  options.initial_arm = "Grid";
  CHECK(swp_session_create(&options, &session) == SWP_NOT_FOUND);
  CHECK(session == NULL);
}

static void check_sessions_without_one(void) {
  swp_verdict verdict = {0, 0, 0};
  swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  swp_frame_sample sample;
  swp_switch_outcome outcome;
  swp_belief belief;
  const swp_pair* pairs = NULL;
  const char* name = NULL;
  uint32_t number = 0;
  uint64_t count = 0;
  REFUSED(swp_session_begin_frame(NULL));
  REFUSED(swp_session_find_pairs(NULL, &box, 1));
  REFUSED(swp_session_pairs(NULL, &pairs, &count));
  REFUSED(swp_session_trim(NULL));
  REFUSED(swp_session_end_frame(NULL, 1, 0));
  REFUSED(swp_session_select_arm(NULL, "SAP"));
  REFUSED(swp_session_set_mode(NULL, SWP_MODE_AI));
  REFUSED(swp_session_freeze(NULL, NULL));
  REFUSED(swp_session_mode(NULL, &number));
  REFUSED(swp_session_active_arm(NULL, &number));
  REFUSED(swp_session_switch_epoch(NULL, &number));
  REFUSED(swp_session_last_sample(NULL, &sample));
  REFUSED(swp_session_arm_count(NULL, &number));
  REFUSED(swp_session_arm_name(NULL, 0, &name));
  REFUSED(swp_session_arm_version(NULL, 0, &number));
  REFUSED(swp_session_dropped(NULL, &count, &count));
  REFUSED(swp_session_shadow_stats(NULL, NULL));
  REFUSED(swp_session_verdict(NULL, &verdict));
  REFUSED(swp_session_attach_decider(NULL, NULL, 0));
  REFUSED(swp_session_detach_decider(NULL));
  REFUSED(swp_session_poll_decider(NULL, 0, NULL, NULL));
  REFUSED(swp_session_beliefs(NULL, &belief, 1, &number));
  REFUSED(swp_session_decision_count(NULL, &count));
  REFUSED(swp_session_prior_source_count(NULL, &count));
  REFUSED(swp_session_export_priors(NULL, NULL, 0, &count));
  REFUSED(swp_session_last_decision(NULL, NULL));
  REFUSED(swp_session_last_outcome(NULL, &outcome));
  swp_session_destroy(NULL);
}

static void check_session_arguments(swp_session* session) {
  const swp_pair* pairs = NULL;
  uint32_t number = 0;
  uint64_t count = 0;
  const char* name = NULL;
  CHECK_OK(swp_session_begin_frame(session));
  REFUSED(swp_session_find_pairs(session, NULL, 1));
  CHECK_OK(swp_session_find_pairs(session, NULL, 0));
  REFUSED(swp_session_pairs(session, NULL, &count));
  REFUSED(swp_session_pairs(session, &pairs, NULL));
  CHECK_OK(swp_session_end_frame(session, 1, 0));
  REFUSED(swp_session_select_arm(session, NULL));
  REFUSED(swp_session_set_mode(session, 0));
  REFUSED(swp_session_mode(session, NULL));
  REFUSED(swp_session_active_arm(session, NULL));
  REFUSED(swp_session_switch_epoch(session, NULL));
  REFUSED(swp_session_last_sample(session, NULL));
  REFUSED(swp_session_arm_count(session, NULL));
  REFUSED(swp_session_arm_name(session, 0, NULL));
  REFUSED(swp_session_arm_name(session, swp_backend_count(), &name));
  REFUSED(swp_session_arm_version(session, 0, NULL));
  REFUSED(swp_session_arm_version(session, swp_backend_count(), &number));
  CHECK_OK(swp_session_dropped(session, NULL, NULL));
  REFUSED(swp_session_shadow_stats(session, NULL));
  REFUSED(swp_session_verdict(session, NULL));
  REFUSED(swp_session_beliefs(session, NULL, 1, &number));
  REFUSED(swp_session_beliefs(session, NULL, 0, NULL));
  REFUSED(swp_session_decision_count(session, NULL));
  REFUSED(swp_session_prior_source_count(session, NULL));
  REFUSED(swp_session_export_priors(session, NULL, 0, NULL));
  REFUSED(swp_session_last_decision(session, NULL));
  REFUSED(swp_session_last_outcome(session, NULL));
  REFUSED(swp_session_export_priors(session, NULL, 1, &count));
}

void test_arguments(void) {
  char text[8];
  swp_session* session = NULL;
  uint32_t number = 0;
  REFUSED(swp_version(NULL, &number, &number));
  REFUSED(swp_last_error_of(NULL, text, sizeof text));
  REFUSED(swp_last_error_of(&number, NULL, 1));
  REFUSED(swp_last_error_of(&number, text, 0));
  REFUSED(swp_decider_options_init(NULL));
  check_worlds();
  check_executors();
  check_proxies_options();
  check_many_shapes();
  check_proxies_without_one();
  check_proxies();
  check_scenes();
  check_session_options();
  check_sessions_without_one();
  CHECK_OK(swp_session_create(NULL, &session));
  check_session_arguments(session);
  swp_session_destroy(session);
}
