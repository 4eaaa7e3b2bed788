/* Tests proxies and threads of the C ABI: compares a small game with an independent search, and
 * tests the rules of handles and buffers, and executors of the caller. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

/* An executor of the caller. */

typedef struct part_count {
  uint64_t calls;
  uint64_t parts;
} part_count;

/* Runs the parts in reverse order. */
static void run_backwards(void* user, uint64_t count, swp_run_part run_part, void* job) {
  part_count* counted = user;
  ++counted->calls;
  counted->parts += count;
  for (uint64_t part = count; part-- > 0;) run_part(job, part);
}

static swp_executor make_executor(part_count* counted) {
  swp_executor executor = {.struct_size = sizeof executor};
  CHECK_OK(swp_executor_init(&executor));
  executor.thread_count = 2;
  executor.run_parts = run_backwards;
  executor.user = counted;
  return executor;
}

static swp_world* make_world(const char* backend, uint32_t thread_count,
                             const swp_executor* executor, uint32_t sorted_pairs) {
  swp_world* world = NULL;
  swp_world_options options = {.struct_size = sizeof options};
  CHECK_OK(swp_world_options_init(&options));
  options.thread_count = thread_count;
  options.executor = executor;
  options.sorted_pairs = sorted_pairs;
  CHECK_OK(swp_world_create(backend, &options, &world));
  return world;
}

static const swp_pair* pairs_of(swp_world* world, const swp_aabb* boxes, uint32_t count,
                                uint64_t* pair_count) {
  const swp_pair* pairs = NULL;
  CHECK_OK(swp_world_build(world, boxes, count));
  CHECK_OK(swp_world_find_pairs(world));
  CHECK_OK(swp_world_pairs(world, &pairs, pair_count));
  return pairs;
}

static void check_threads_of(const char* backend, const swp_aabb* boxes, uint32_t count) {
  part_count counted = {0, 0};
  const swp_executor executor = make_executor(&counted);
  swp_world* worlds[3] = {make_world(backend, 0, NULL, 0), make_world(backend, 2, NULL, 0),
                          make_world(backend, 0, &executor, 0)};
  uint64_t alone_count = 0;
  const swp_pair* alone = pairs_of(worlds[0], boxes, count, &alone_count);
  for (int i = 1; i < 3; ++i) {
    uint64_t found_count = 0;
    const swp_pair* found = pairs_of(worlds[i], boxes, count, &found_count);
    CHECK(found_count == alone_count);
    CHECK(memcmp(found, alone, alone_count * sizeof *alone) == 0);
  }
  CHECK(counted.parts >= counted.calls);
  for (int i = 0; i < 3; ++i) swp_world_destroy(worlds[i]);
}

static void check_sorted_world(const swp_aabb* boxes, uint32_t count) {
  swp_world* world = make_world("Grid", 0, NULL, 1);
  uint64_t found_count = 0;
  uint64_t right_count = 0;
  const swp_pair* found = pairs_of(world, boxes, count, &found_count);
  swp_pair* right = brute_force(boxes, count, &right_count);
  CHECK(found_count == right_count);
  CHECK(memcmp(found, right, right_count * sizeof *right) == 0);
  free(right);
  swp_world_destroy(world);
}

static void check_session_with_executor(const swp_aabb* boxes, uint32_t count) {
  part_count counted = {0, 0};
  const swp_executor executor = make_executor(&counted);
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  const swp_pair* pairs = NULL;
  uint64_t pair_count = 0;
  CHECK_OK(swp_session_options_init(&options));
  options.executor = &executor;
  CHECK_OK(swp_session_create(&options, &session));
  CHECK_OK(swp_session_begin_frame(session));
  CHECK_OK(swp_session_find_pairs(session, boxes, count));
  CHECK_OK(swp_session_pairs(session, &pairs, &pair_count));
  CHECK(pair_count > 0 && counted.calls > 0);
  CHECK_OK(swp_session_end_frame(session, 1, 0));
  swp_session_destroy(session);
}

void test_threads(void) {
  swp_scene* scene = make_scene("suite-b", 9000);
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  CHECK_OK(swp_scene_boxes(scene, &boxes, &count));
  for (uint32_t i = 0; i < swp_backend_count(); ++i) {
    check_threads_of(swp_backend_name(i), boxes, count);
  }
  check_sorted_world(boxes, 2000);
  check_session_with_executor(boxes, count);
  swp_scene_destroy(scene);
}

/* Proxies. */

#define OBJECTS 300U

/* Every third proxy is static; categories and masks have three bits. */
typedef struct game {
  swp_scene* scene;
  swp_world* world;
  swp_proxies* proxies;
  swp_proxy handles[OBJECTS];
  swp_aabb boxes[OBJECTS];
} game;

static swp_proxy_options options_of(uint32_t object) {
  swp_proxy_options options = {
      {1U << object % 3, object % 7 + 1}, object % 3 == 0 ? SWP_PROXY_STATIC : 0, 0, 0};
  options.user = object;
  return options;
}

static void start(game* played) {
  swp_proxies_options options = {.struct_size = sizeof options};
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  CHECK_OK(swp_proxies_options_init(&options));
  options.pair_events = 1;
  options.thread_count = 2;
  played->scene = make_scene("suite-b", OBJECTS);
  CHECK_OK(swp_world_create("SAP", NULL, &played->world));
  CHECK_OK(swp_proxies_create(&options, &played->proxies));
  CHECK_OK(swp_scene_boxes(played->scene, &boxes, &count));
  memcpy(played->boxes, boxes, sizeof played->boxes);
  swp_proxy_options chosen[OBJECTS];
  for (uint32_t i = 0; i < OBJECTS; ++i) chosen[i] = options_of(i);
  CHECK_OK(swp_proxies_add_many(played->proxies, boxes, chosen, OBJECTS, played->handles));
  CHECK_OK(swp_world_build(played->world, NULL, 0));
}

static void end(game* played) {
  swp_proxies_destroy(played->proxies);
  swp_world_destroy(played->world);
  swp_scene_destroy(played->scene);
}

static uint32_t object_of(const game* played, uint32_t id) {
  swp_proxy handle;
  swp_proxy_options options = {{0, 0}, 0, 0, 0};
  CHECK_OK(swp_proxies_handle(played->proxies, id, &handle));
  CHECK_OK(swp_proxies_get(played->proxies, handle, NULL, &options));
  return (uint32_t)options.user;
}

static int is_pair(uint32_t a, uint32_t b) {
  const swp_proxy_options one = options_of(a);
  const swp_proxy_options other = options_of(b);
  return (one.flags & other.flags & SWP_PROXY_STATIC) == 0 &&
         (one.filter.category & other.filter.mask) != 0 &&
         (other.filter.category & one.filter.mask) != 0;
}

/* Returns the pairs that brute force finds and whose filters match, as numbers of objects. */
static swp_pair* right_pairs(const game* played, uint64_t* count) {
  uint64_t all_count = 0;
  swp_pair* pairs = brute_force(played->boxes, OBJECTS, &all_count);
  *count = 0;
  for (uint64_t i = 0; i < all_count; ++i) {
    if (is_pair(pairs[i].a, pairs[i].b)) pairs[(*count)++] = pairs[i];
  }
  return pairs;
}

static void step(game* played) {
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  CHECK_OK(swp_scene_step(played->scene));
  CHECK_OK(swp_scene_boxes(played->scene, &boxes, &count));
  for (uint32_t i = 0; i < OBJECTS; ++i) {
    if (i % 3 == 0) continue;
    played->boxes[i] = boxes[i];
    CHECK_OK(swp_proxies_set_boxes(played->proxies, &played->handles[i], &boxes[i], 1));
  }
}

/* Resolves the pairs of this frame. Returns a copy, which the caller frees. */
static swp_pair* resolved_pairs(game* played, uint64_t* count) {
  const swp_aabb* moving = NULL;
  const swp_pair* found = NULL;
  const swp_pair* resolved = NULL;
  uint32_t moving_count = 0;
  uint64_t found_count = 0;
  CHECK_OK(swp_proxies_moving_boxes(played->proxies, &moving, &moving_count));
  CHECK_OK(swp_world_update(played->world, moving, moving_count));
  CHECK_OK(swp_world_find_pairs(played->world));
  CHECK_OK(swp_world_pairs(played->world, &found, &found_count));
  CHECK_OK(swp_proxies_resolve(played->proxies, found, found_count));
  CHECK_OK(swp_proxies_pairs(played->proxies, &resolved, count));
  return copy_pairs(resolved, *count);
}

static void to_objects(const game* played, swp_pair* pairs, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t a = object_of(played, pairs[i].a);
    const uint32_t b = object_of(played, pairs[i].b);
    pairs[i].a = a < b ? a : b;
    pairs[i].b = a < b ? b : a;
  }
}

static void check_game(void) {
  game played;
  uint64_t before_count = 0;
  start(&played);
  for (int frame = 0; frame < 20; ++frame) {
    uint64_t count = 0;
    uint64_t right_count = 0;
    uint64_t added_count = 0;
    uint64_t removed_count = 0;
    const swp_proxy_pair* events = NULL;
    swp_pair* pairs = resolved_pairs(&played, &count);
    swp_pair* right = right_pairs(&played, &right_count);
    to_objects(&played, pairs, count);
    CHECK(right_count > 0 && same_pairs(pairs, count, right, right_count));
    CHECK_OK(swp_proxies_added(played.proxies, &events, &added_count));
    CHECK(SWP_PROXY_ID(events[0].a) < SWP_PROXY_ID(events[0].b));
    CHECK_OK(swp_proxies_removed(played.proxies, &events, &removed_count));
    CHECK(before_count + added_count - removed_count == count);
    CHECK(added_count > 0 && (frame == 0 || added_count < count));
    before_count = count;
    free(pairs);
    free(right);
    step(&played);
  }
  end(&played);
}

static const swp_aabb kUnit = {{0, 0, 0}, {1, 1, 1}};
static const swp_aabb kTouching = {{1, 1, 1}, {2, 2, 2}};
static const swp_filter kAll = {1, 0xffffffffU};

static swp_proxy add(swp_proxies* proxies, const swp_aabb* box, const swp_proxy_options* options) {
  swp_proxy added = 0;
  CHECK_OK(swp_proxies_add_many(proxies, box, options, 1, &added));
  CHECK(added != 0);
  return added;
}

static void check_handles(swp_proxies* proxies) {
  const swp_proxy first = add(proxies, &kUnit, NULL);
  swp_aabb box = kTouching;
  swp_proxy none = 9;
  uint32_t moving_count = 0;
  CHECK_OK(swp_proxies_get(proxies, first, &box, NULL));
  CHECK(memcmp(&box, &kUnit, sizeof box) == 0);
  CHECK_OK(swp_proxies_set_user(proxies, first, 5));
  CHECK_OK(swp_proxies_remove_many(proxies, &first, 1));
  const swp_proxy second = add(proxies, &kUnit, NULL);
  CHECK(SWP_PROXY_ID(second) == SWP_PROXY_ID(first) && second != first);
  const swp_proxy stale[2] = {first, 0};
  for (int i = 0; i < 2; ++i) {
    const swp_proxy pair[2] = {second, stale[i]};
    const swp_aabb boxes[2] = {kTouching, kTouching};
    CHECK(swp_proxies_remove_many(proxies, pair, 2) == SWP_NOT_FOUND);
    CHECK(strlen(swp_last_error()) > 0);
    CHECK(swp_proxies_set_boxes(proxies, pair, boxes, 2) == SWP_NOT_FOUND);
    CHECK(swp_proxies_set_filter(proxies, stale[i], &kAll) == SWP_NOT_FOUND);
    CHECK(swp_proxies_set_user(proxies, stale[i], 1) == SWP_NOT_FOUND);
    CHECK(swp_proxies_get(proxies, stale[i], &box, NULL) == SWP_NOT_FOUND);
  }
  CHECK(swp_proxies_handle(proxies, 77, &none) == SWP_NOT_FOUND);
  CHECK_OK(swp_proxies_get(proxies, second, &box, NULL));
  CHECK(none == 9 && memcmp(&box, &kUnit, sizeof box) == 0);
  CHECK_OK(swp_proxies_counts(proxies, &moving_count, NULL, NULL));
  CHECK(moving_count == 1);
}

/* Adds a second proxy to the set, and removes both together, one of them twice in the list. */
static void check_batches(swp_proxies* proxies) {
  const swp_aabb boxes[3] = {kUnit, kTouching, kUnit};
  const swp_proxy_options options[3] = {
      {{1, 1}, 0, 0, 10}, {{1, 1}, SWP_PROXY_STATIC, 0, 11}, {{1, 1}, 0, 0, 12}};
  swp_proxy added[4];
  uint32_t moving_count = 0;
  uint32_t static_count = 0;
  CHECK_OK(swp_proxies_add_many(proxies, boxes, options, 3, added));
  for (uint64_t i = 0; i < 3; ++i) {
    swp_proxy_options got;
    CHECK_OK(swp_proxies_get(proxies, added[i], NULL, &got));
    CHECK(got.user == 10 + i && got.flags == options[i].flags);
  }
  CHECK_OK(swp_proxies_counts(proxies, &moving_count, &static_count, NULL));
  CHECK(moving_count == 3 && static_count == 1);
  added[3] = added[0];
  CHECK_OK(swp_proxies_remove_many(proxies, added, 4));
  CHECK_OK(swp_proxies_counts(proxies, &moving_count, &static_count, NULL));
  CHECK(moving_count == 1 && static_count == 0);
}

static void check_resolve(swp_proxies* proxies) {
  const swp_pair found = {0, 1};
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  add(proxies, &kTouching, NULL);
  CHECK(swp_proxies_pairs(proxies, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_proxies_resolve(proxies, &found, 1));
  CHECK_OK(swp_proxies_pairs(proxies, &pairs, &count));
  CHECK(count == 1 && pairs[0].a == 0 && pairs[0].b == 1);
}

/* Queries three boxes, of which the middle one finds nothing. */
static void check_query_boxes(const swp_proxies* proxies, swp_proxy resting) {
  const swp_aabb boxes[3] = {
      {{1, 1, 1}, {1, 1, 1}}, {{8, 8, 8}, {9, 9, 9}}, {{1.5F, 1.5F, 1.5F}, {9, 9, 9}}};
  swp_proxy found[4] = {9, 9, 9, 9};
  uint64_t ends[3];
  CHECK(swp_proxies_query_boxes(proxies, boxes, 3, NULL, found, 3, ends) == SWP_RESOURCE_EXHAUSTED);
  CHECK(ends[0] == 3 && ends[1] == 3 && ends[2] == 4);
  CHECK_OK(swp_proxies_query_boxes(proxies, boxes, 3, NULL, found, 4, ends));
  CHECK(SWP_PROXY_ID(found[0]) < SWP_PROXY_ID(found[1]) && found[2] == resting);
  CHECK(ends[2] == 4 && found[3] == found[1]);
}

static void check_rays(const swp_proxies* proxies, swp_proxy resting) {
  swp_ray rays[2] = {{{-1, 0.5F, 0.5F}, {2, 0, 0}, 10}, {{-1, 0.5F, 0.5F}, {-2, 0, 0}, 10}};
  const swp_filter nobody = {2, 0};
  swp_ray_hit all[2];
  swp_ray_hit nearest[2];
  uint64_t count = 0;
  CHECK(swp_proxies_cast_ray(proxies, rays, &kAll, all, 1, &count) == SWP_RESOURCE_EXHAUSTED);
  CHECK(count == 2);
  CHECK_OK(swp_proxies_cast_ray(proxies, rays, &kAll, all, 2, &count));
  CHECK(count == 2 && all[0].distance == 0.5F && all[1].proxy == resting);
  CHECK_OK(swp_proxies_cast_rays(proxies, rays, 2, &kAll, nearest));
  CHECK(nearest[0].proxy == all[0].proxy && nearest[0].distance == 0.5F);
  CHECK(nearest[1].proxy == 0 && nearest[1].distance == 0);
  CHECK_OK(swp_proxies_cast_rays(proxies, rays, 1, &nobody, nearest));
  CHECK(nearest[0].proxy == 0);
  nearest[0].proxy = 9;
  rays[1].direction[0] = NAN;
  CHECK(swp_proxies_cast_ray(proxies, &rays[1], NULL, all, 2, &count) == SWP_INVALID_ARGUMENT);
  CHECK(swp_proxies_cast_rays(proxies, rays, 2, NULL, nearest) == SWP_INVALID_ARGUMENT);
  CHECK(nearest[0].proxy == 9);
}

/* After every change the queries have to be prepared again. */
static void check_queries(swp_proxies* proxies) {
  const swp_proxy_options options = {{1, 0xffffffffU}, SWP_PROXY_STATIC, 0, 42};
  const swp_ray ray = {{0, 0, 0}, {1, 0, 0}, 1};
  swp_ray_hit hit;
  uint64_t end = 0;
  CHECK_OK(swp_proxies_prepare_queries(proxies));
  const swp_proxy resting = add(proxies, &kUnit, &options);
  CHECK((SWP_PROXY_ID(resting) & SWP_STATIC_PROXY_BIT) != 0);
  CHECK(swp_proxies_query_boxes(proxies, &kUnit, 1, NULL, NULL, 0, &end) ==
        SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_cast_ray(proxies, &ray, NULL, &hit, 1, &end) == SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_cast_rays(proxies, &ray, 1, NULL, &hit) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_proxies_prepare_queries(proxies));
  check_query_boxes(proxies, resting);
  check_rays(proxies, resting);
}

static void check_rest(void) {
  const swp_proxy_options wall = {{1, 0xffffffffU}, SWP_PROXY_STATIC, 0, 0};
  const float offset[3] = {1, 0, 0};
  const swp_aabb* boxes = NULL;
  const swp_pair* pairs = NULL;
  swp_proxy_options options;
  swp_aabb box;
  uint64_t count = 0;
  uint32_t moving = 0;
  swp_proxies* proxies = NULL;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  const swp_proxy ball = add(proxies, &kUnit, NULL);
  const swp_proxy other = add(proxies, &kTouching, &wall);
  CHECK_OK(swp_proxies_set_sleeping(proxies, ball, 1));
  CHECK_OK(swp_proxies_get(proxies, ball, NULL, &options));
  CHECK(options.flags == SWP_PROXY_SLEEPING);
  CHECK_OK(swp_proxies_resolve(proxies, NULL, 0));
  CHECK_OK(swp_proxies_pairs(proxies, &pairs, &count));
  CHECK(count == 1 && pairs[0].a == SWP_PROXY_ID(ball) && pairs[0].b == SWP_PROXY_ID(other));
  CHECK_OK(swp_proxies_shift_origin(proxies, offset));
  CHECK_OK(swp_proxies_get(proxies, ball, &box, NULL));
  CHECK(box.min[0] == -1 && box.max[0] == 0 && box.max[1] == 1);
  CHECK_OK(swp_proxies_set_static(proxies, ball, 1));
  CHECK_OK(swp_proxies_resolve(proxies, NULL, 0));
  CHECK_OK(swp_proxies_pairs(proxies, &pairs, &count));
  CHECK(count == 0);
  CHECK_OK(swp_proxies_remove_many(proxies, &ball, 1));
  CHECK_OK(swp_proxies_moving_boxes(proxies, &boxes, &moving));
  CHECK(moving == 0);
  CHECK(swp_proxies_set_static(proxies, ball, 1) == SWP_NOT_FOUND);
  CHECK(swp_proxies_set_sleeping(proxies, ball, 1) == SWP_NOT_FOUND);
  swp_proxies_destroy(proxies);
}

static void check_snapshot(void) {
  uint64_t bytes = 0;
  uint64_t same = 0;
  swp_proxies* proxies = NULL;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  const swp_proxy kept = add(proxies, &kUnit, NULL);
  CHECK_OK(swp_proxies_snapshot_bytes(proxies, &bytes));
  char* snapshot = malloc(bytes);
  CHECK_OK(swp_proxies_save(proxies, snapshot, bytes));
  const swp_proxy lost = add(proxies, &kUnit, NULL);
  CHECK(swp_proxies_restore(proxies, snapshot, bytes - 1) == SWP_DATA_LOSS);
  CHECK_OK(swp_proxies_get(proxies, lost, NULL, NULL));
  CHECK_OK(swp_proxies_restore(proxies, snapshot, bytes));
  CHECK_OK(swp_proxies_get(proxies, kept, NULL, NULL));
  CHECK(swp_proxies_get(proxies, lost, NULL, NULL) == SWP_NOT_FOUND);
  CHECK(add(proxies, &kUnit, NULL) == lost);
  CHECK_OK(swp_proxies_snapshot_bytes(proxies, &same));
  CHECK(same > bytes);
  free(snapshot);
  swp_proxies_destroy(proxies);
}

static void check_shapes(void) {
  const swp_sphere spheres[2] = {{{-1, 0.5F, 0.5F}, 1}, {{5, 5, 5}, 1}};
  const swp_box_sweep sweeps[2] = {{{{-3, 0, 0}, {-2, 1, 1}}, {4, 0, 0}},
                                   {{{-3, 0, 0}, {-2, 1, 1}}, {1, 0, 0}}};
  const double low[3] = {0.1, 0, 0};
  const double high[3] = {0.1, 0, 0};
  swp_aabb box;
  swp_proxy found[2] = {0, 0};
  swp_ray_hit hits[2];
  uint64_t ends[2] = {9, 9};
  swp_proxies* proxies = NULL;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  const swp_proxy ball = add(proxies, &kUnit, NULL);
  CHECK(swp_proxies_query_spheres(proxies, spheres, 2, NULL, found, 2, ends) ==
        SWP_FAILED_PRECONDITION);
  CHECK(swp_proxies_sweep_boxes(proxies, sweeps, 2, NULL, hits) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_proxies_prepare_queries(proxies));
  CHECK_OK(swp_proxies_query_spheres(proxies, spheres, 2, NULL, found, 2, ends));
  CHECK(ends[0] == 1 && ends[1] == 1 && found[0] == ball);
  CHECK(swp_proxies_query_spheres(proxies, spheres, 2, NULL, NULL, 0, ends) ==
        SWP_RESOURCE_EXHAUSTED);
  CHECK(ends[1] == 1);
  CHECK_OK(swp_proxies_sweep_boxes(proxies, sweeps, 2, NULL, hits));
  CHECK(hits[0].proxy == ball && hits[0].distance == 0.5F);
  CHECK(hits[1].proxy == 0);
  CHECK_OK(swp_round_outward(low, high, &box));
  CHECK((double)box.min[0] <= 0.1 && (double)box.max[0] >= 0.1 && box.min[0] < box.max[0]);
  swp_proxies_destroy(proxies);
}

/* A resolve with more pairs than max_pairs fails; the next one reports all events. */
static void check_max_pairs(void) {
  swp_proxies_options options = {.struct_size = sizeof options};
  swp_proxies* proxies = NULL;
  swp_proxy sleeping[4];
  const swp_pair* pairs = NULL;
  const swp_proxy_pair* events = NULL;
  uint64_t count = 0;
  CHECK_OK(swp_proxies_options_init(&options));
  CHECK(options.max_pairs == 0);
  options.pair_events = 1;
  options.max_pairs = 5;
  CHECK_OK(swp_proxies_create(&options, &proxies));
  for (int i = 0; i < 4; ++i) {
    sleeping[i] = add(proxies, &kUnit, NULL);
    CHECK_OK(swp_proxies_set_sleeping(proxies, sleeping[i], 1));
  }
  CHECK(swp_proxies_resolve(proxies, NULL, 0) == SWP_RESOURCE_EXHAUSTED);
  CHECK(strstr(swp_last_error(), "max_pairs") != NULL);
  CHECK(swp_proxies_pairs(proxies, &pairs, &count) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_proxies_added(proxies, &events, &count));
  CHECK(count == 0);
  CHECK_OK(swp_proxies_remove_many(proxies, &sleeping[3], 1));
  CHECK_OK(swp_proxies_resolve(proxies, NULL, 0));
  CHECK_OK(swp_proxies_pairs(proxies, &pairs, &count));
  CHECK(count == 3);
  CHECK_OK(swp_proxies_added(proxies, &events, &count));
  CHECK(count == 3);
  swp_proxies_destroy(proxies);
}

void test_proxies(void) {
  swp_proxies* proxies = NULL;
  check_game();
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  check_handles(proxies);
  check_batches(proxies);
  check_resolve(proxies);
  check_queries(proxies);
  swp_proxies_destroy(proxies);
  check_rest();
  check_snapshot();
  check_max_pairs();
  check_shapes();
}
