/* Proxies and threads of the C ABI: a small game against a search of this program, the rules of
 * handles and buffers, and executors of the caller's own. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

/* ---- an executor of this program ---- */

typedef struct part_count {
  uint64_t calls;
  uint64_t parts;
} part_count;

/* Runs the parts backwards. */
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
  CHECK_OK(swp_world_create_with(backend, &options, &world));
  return world;
}

static swp_pair* pairs_of(swp_world* world, const swp_aabb* boxes, uint32_t count,
                          uint64_t* pair_count) {
  *pair_count = 0;
  CHECK_OK(swp_world_build(world, boxes, count));
  swp_world_find_pairs(world, NULL, 0, pair_count);
  swp_pair* pairs = malloc((*pair_count + 1) * sizeof *pairs);
  CHECK_OK(swp_world_find_pairs(world, pairs, *pair_count, pair_count));
  return pairs;
}

static void check_threads_of(const char* backend, const swp_aabb* boxes, uint32_t count) {
  part_count counted = {0, 0};
  const swp_executor executor = make_executor(&counted);
  swp_world* worlds[3] = {make_world(backend, 0, NULL, 0), make_world(backend, 2, NULL, 0),
                          make_world(backend, 0, &executor, 0)};
  uint64_t alone_count = 0;
  swp_pair* alone = pairs_of(worlds[0], boxes, count, &alone_count);
  for (int i = 1; i < 3; ++i) {
    uint64_t found_count = 0;
    swp_pair* found = pairs_of(worlds[i], boxes, count, &found_count);
    CHECK(found_count == alone_count);
    CHECK(memcmp(found, alone, alone_count * sizeof *alone) == 0);
    free(found);
  }
  CHECK(counted.parts >= counted.calls);
  free(alone);
  for (int i = 0; i < 3; ++i) swp_world_destroy(worlds[i]);
}

static void check_sorted_world(const swp_aabb* boxes, uint32_t count) {
  swp_world* world = make_world("Grid", 0, NULL, 1);
  uint64_t found_count = 0;
  uint64_t right_count = 0;
  swp_pair* found = pairs_of(world, boxes, count, &found_count);
  swp_pair* right = brute_force(boxes, count, &right_count);
  CHECK(found_count == right_count);
  CHECK(memcmp(found, right, right_count * sizeof *right) == 0);
  free(found);
  free(right);
  swp_world_destroy(world);
}

static void check_session_with_executor(const swp_aabb* boxes, uint32_t count) {
  part_count counted = {0, 0};
  const swp_executor executor = make_executor(&counted);
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  uint64_t pair_count = 0;
  CHECK_OK(swp_session_options_init(&options));
  options.executor = &executor;
  CHECK_OK(swp_session_create(&options, &session));
  CHECK_OK(swp_session_begin_frame(session));
  CHECK(swp_session_find_pairs(session, boxes, count, NULL, 0, &pair_count) ==
        SWP_RESOURCE_EXHAUSTED);
  CHECK(pair_count > 0);
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

/* ---- proxies ---- */

#define OBJECTS 300U

/* Every third is static; categories and masks of three bits. */
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
  CHECK_OK(swp_world_create("SAP", &played->world));
  CHECK_OK(swp_proxies_create(&options, &played->proxies));
  CHECK_OK(swp_scene_boxes(played->scene, &boxes, &count));
  memcpy(played->boxes, boxes, sizeof played->boxes);
  for (uint32_t i = 0; i < OBJECTS; ++i) {
    const swp_proxy_options chosen = options_of(i);
    CHECK_OK(swp_proxies_add(played->proxies, &boxes[i], &chosen, &played->handles[i]));
  }
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

/* By objects: those of the brute force that pass. */
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
    CHECK_OK(swp_proxies_move(played->proxies, &played->handles[i], &boxes[i], 1));
  }
}

static swp_pair* resolved_pairs(game* played, uint64_t* count) {
  const swp_aabb* moving = NULL;
  uint32_t moving_count = 0;
  uint64_t found_count = 0;
  CHECK_OK(swp_proxies_moving_boxes(played->proxies, &moving, &moving_count));
  CHECK_OK(swp_world_update(played->world, moving, moving_count));
  swp_world_find_pairs(played->world, NULL, 0, &found_count);
  swp_pair* found = malloc((found_count + 1) * sizeof *found);
  CHECK_OK(swp_world_find_pairs(played->world, found, found_count, &found_count));
  *count = 0;
  const swp_result first = swp_proxies_resolve(played->proxies, found, found_count, NULL, 0, count);
  CHECK(first == (*count == 0 ? SWP_OK : SWP_RESOURCE_EXHAUSTED));
  free(found);
  swp_pair* pairs = malloc((*count + 1) * sizeof *pairs);
  CHECK_OK(swp_proxies_copy_pairs(played->proxies, pairs, *count, count));
  return pairs;
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
    swp_pair* pairs = resolved_pairs(&played, &count);
    swp_pair* right = right_pairs(&played, &right_count);
    to_objects(&played, pairs, count);
    CHECK(right_count > 0 && same_pairs(pairs, count, right, right_count));
    swp_proxies_added(played.proxies, NULL, 0, &added_count);
    swp_proxies_removed(played.proxies, NULL, 0, &removed_count);
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

static void check_handles(swp_proxies* proxies) {
  swp_proxy first = 9;
  swp_proxy second = 9;
  const swp_proxy none = 0;
  swp_aabb box = kTouching;
  uint32_t moving_count = 0;
  CHECK_OK(swp_proxies_add(proxies, &kUnit, NULL, &first));
  CHECK_OK(swp_proxies_get(proxies, first, &box, NULL));
  CHECK(memcmp(&box, &kUnit, sizeof box) == 0);
  CHECK_OK(swp_proxies_set_user(proxies, first, 5));
  CHECK_OK(swp_proxies_remove(proxies, first));
  CHECK_OK(swp_proxies_add(proxies, &kUnit, NULL, &second));
  CHECK(SWP_PROXY_ID(second) == SWP_PROXY_ID(first) && second != first);
  const swp_proxy stale[2] = {first, none};
  for (int i = 0; i < 2; ++i) {
    const swp_proxy pair[2] = {second, stale[i]};
    const swp_aabb boxes[2] = {kTouching, kTouching};
    CHECK(swp_proxies_remove(proxies, stale[i]) == SWP_NOT_FOUND);
    CHECK(strlen(swp_last_error()) > 0);
    CHECK(swp_proxies_move(proxies, pair, boxes, 2) == SWP_NOT_FOUND);
    CHECK(swp_proxies_set_filter(proxies, stale[i], &kAll) == SWP_NOT_FOUND);
    CHECK(swp_proxies_set_user(proxies, stale[i], 1) == SWP_NOT_FOUND);
    CHECK(swp_proxies_get(proxies, stale[i], &box, NULL) == SWP_NOT_FOUND);
  }
  CHECK(swp_proxies_handle(proxies, 77, &first) == SWP_NOT_FOUND);
  CHECK_OK(swp_proxies_get(proxies, second, &box, NULL));
  CHECK(memcmp(&box, &kUnit, sizeof box) == 0);
  CHECK_OK(swp_proxies_counts(proxies, &moving_count, NULL, NULL));
  CHECK(moving_count == 1);
}

/* The caller's memory is his own once the call is over. */
static void check_that_pairs_are_kept(swp_proxies* proxies) {
  swp_proxy other;
  swp_pair found = {0, 1};
  swp_pair kept = {9, 9};
  uint64_t count = 0;
  CHECK_OK(swp_proxies_add(proxies, &kTouching, NULL, &other));
  CHECK(swp_proxies_copy_pairs(proxies, &kept, 1, &count) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_proxies_resolve(proxies, &found, 1, &kept, 1, &count));
  found.a = 7;
  CHECK_OK(swp_proxies_copy_pairs(proxies, &kept, 1, &count));
  CHECK(count == 1 && kept.a == 0 && kept.b == 1);
}

static void check_queries(swp_proxies* proxies) {
  const swp_proxy_options resting = {{1, 0xffffffffU}, SWP_PROXY_STATIC, 0, 42};
  const swp_aabb small = {{1, 1, 1}, {1, 1, 1}};
  swp_ray ray = {{-1, 0.5F, 0.5F}, {2, 0, 0}, 10};
  swp_proxy added;
  swp_proxy found[3];
  swp_ray_hit hits[2];
  swp_ray_hit nearest;
  uint64_t count = 0;
  uint32_t any = 9;
  CHECK_OK(swp_proxies_add(proxies, &kUnit, &resting, &added));
  CHECK((SWP_PROXY_ID(added) & SWP_STATIC_PROXY_BIT) != 0);
  CHECK(swp_proxies_query_box(proxies, &small, NULL, found, 2, &count) == SWP_RESOURCE_EXHAUSTED);
  CHECK(count == 3);
  CHECK_OK(swp_proxies_query_box(proxies, &small, NULL, found, 3, &count));
  CHECK(count == 3 && found[2] == added && SWP_PROXY_ID(found[0]) < SWP_PROXY_ID(found[1]));
  CHECK_OK(swp_proxies_cast_ray(proxies, &ray, &kAll, hits, 2, &count));
  CHECK(count == 2 && hits[0].distance == 0.5F && hits[1].proxy == added);
  CHECK_OK(swp_proxies_cast_ray_nearest(proxies, &ray, &kAll, &nearest, &any));
  CHECK(any == 1 && nearest.proxy == hits[0].proxy);
  ray.direction[0] = -1;
  CHECK_OK(swp_proxies_cast_ray_nearest(proxies, &ray, &kAll, &nearest, &any));
  CHECK(any == 0 && nearest.proxy == hits[0].proxy);
  ray.direction[0] = NAN;
  CHECK(swp_proxies_cast_ray(proxies, &ray, &kAll, hits, 2, &count) == SWP_INVALID_ARGUMENT);
  CHECK(swp_proxies_cast_ray_nearest(proxies, &ray, &kAll, &nearest, &any) == SWP_INVALID_ARGUMENT);
}

void test_proxies(void) {
  swp_proxies* proxies = NULL;
  check_game();
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  check_handles(proxies);
  check_that_pairs_are_kept(proxies);
  check_queries(proxies);
  swp_proxies_destroy(proxies);
}
