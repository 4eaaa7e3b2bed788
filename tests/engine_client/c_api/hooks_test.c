/* Tests the memory, zones and threads of the game over the life of a session. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

typedef struct seen {
  uint64_t allocation_count;
  uint64_t release_count;
  uint64_t search_count;
  uint64_t decide_count;
  uint64_t open_zone_count;
  uint64_t pool_thread_count;
  uint64_t allocations_left; /* counts down while memory is short */
  int is_short;
} seen;

static void* allocate(uint64_t bytes, uint64_t alignment, void* user) {
  seen* counts = user;
  if (counts->is_short && counts->allocations_left-- == 0) return NULL;
  ++counts->allocation_count;
  /* Windows does not have aligned_alloc: the block's own address is stored before the returned
   * address. */
  char* const block = malloc(bytes + alignment + sizeof block);
  if (block == NULL) return NULL;
  char* const first = block + sizeof block;
  char* const given = first + (alignment - (uintptr_t)first % alignment) % alignment;
  memcpy(given - sizeof block, &block, sizeof block);
  return given;
}

static void release(void* pointer, uint64_t bytes, uint64_t alignment, void* user) {
  (void)bytes;
  (void)alignment;
  ++((seen*)user)->release_count;
  void* block = NULL;
  memcpy(&block, (char*)pointer - sizeof block, sizeof block);
  free(block);
}

static void begin_zone(const char* name, void* user) {
  ++((seen*)user)->open_zone_count;
  ((seen*)user)->search_count += strcmp(name, "sweepstake: search") == 0;
  ((seen*)user)->decide_count += strcmp(name, "sweepstake: decide") == 0;
}

static void end_zone(const char* name, void* user) {
  (void)name;
  --((seen*)user)->open_zone_count;
}

static void start_thread(const char* name, void* user) {
  ((seen*)user)->pool_thread_count += strcmp(name, "swp pool") == 0;
}

/* Returns a session that uses the hooks, with a pool of two threads. */
static swp_session* make_session(uint64_t memory_budget_bytes) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_options_init(&options));
  options.arms = "SAP,KDTree";
  options.shadow = SWP_SHADOW_OFF; /* so that the calling thread makes every allocation */
  options.mode = SWP_MODE_MANUAL;
  options.thread_count = 2;
  options.memory_budget_bytes = memory_budget_bytes;
  CHECK_OK(swp_session_create(&options, &session));
  return session;
}

static void run_frame(swp_session* session) {
  static const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}};
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  CHECK_OK(swp_session_begin_frame(session));
  CHECK(swp_session_trim(session) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_session_find_pairs(session, boxes, 2));
  CHECK_OK(swp_session_pairs(session, &pairs, &count));
  CHECK(count == 1);
  CHECK_OK(swp_session_end_frame(session, 1000, 0));
}

static void check_trim(seen* counts) {
  swp_session* session = make_session(0);
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  run_frame(session);
  CHECK_OK(swp_session_select_arm(session, "KDTree"));
  run_frame(session);
  const uint64_t held = counts->allocation_count - counts->release_count;
  CHECK_OK(swp_session_trim(session));
  CHECK(counts->allocation_count - counts->release_count < held);
  CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
  run_frame(session);
  swp_session_destroy(session);
}

static void check_budget(seen* counts) {
  for (uint64_t budget = 0; budget < 2; ++budget) {
    swp_session* session = make_session(budget);
    run_frame(session);
    const uint64_t released = counts->release_count;
    CHECK_OK(swp_session_select_arm(session, "KDTree"));
    CHECK_OK(swp_session_begin_frame(session));
    CHECK((counts->release_count > released) == (budget == 1));
    swp_session_destroy(session);
  }
}

/* Makes the second search of a frame with memory for `allocation_count` blocks only. Returns its
 * result. */
static swp_result search_short_of_memory(seen* counts, uint64_t allocation_count) {
  enum { kMany = 3000 };
  static swp_aabb boxes[kMany];
  const swp_pair* pairs = NULL;
  uint64_t count = 99;
  for (int i = 0; i < kMany; ++i) {
    const float x = (float)i;
    boxes[i] = (swp_aabb){{x, 0, 0}, {x + 1, 1, 1}};
  }
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_options_init(&options));
  options.shadow = SWP_SHADOW_OFF;
  CHECK_OK(swp_session_create(&options, &session));
  CHECK_OK(swp_session_begin_frame(session));
  CHECK_OK(swp_session_find_pairs(session, boxes, 2));
  counts->is_short = 1;
  counts->allocations_left = allocation_count;
  const swp_result result = swp_session_find_pairs(session, boxes, kMany);
  counts->is_short = 0;
  if (result != SWP_OK) {
    CHECK(swp_session_pairs(session, &pairs, &count) == SWP_FAILED_PRECONDITION);
    CHECK(pairs == NULL && count == 99);
    CHECK_OK(swp_session_find_pairs(session, boxes, kMany));
  }
  CHECK_OK(swp_session_pairs(session, &pairs, &count));
  CHECK(count == kMany - 1);
  CHECK_OK(swp_session_end_frame(session, 1000, 0));
  swp_session_destroy(session);
  return result;
}

/* Whichever allocation fails, no pairs of the former search remain. */
static void check_out_of_memory(seen* counts) {
  uint64_t allocation_count = 0;
  while (search_short_of_memory(counts, allocation_count) == SWP_RESOURCE_EXHAUSTED) {
    ++allocation_count;
  }
  CHECK(allocation_count > 0);
}

/* Adds many proxies to a set of one moving and one static proxy, with memory for `allocation_count`
 * blocks only. Returns the result. */
static swp_result add_short_of_memory(seen* counts, uint64_t allocation_count) {
  enum { kMany = 300 };
  static const swp_aabb unit = {{0, 0, 0}, {1, 1, 1}};
  swp_aabb boxes[kMany];
  swp_proxy_options options[kMany];
  swp_proxy added[kMany];
  swp_proxy first[2];
  for (uint32_t k = 0; k < kMany; ++k) {
    boxes[k] = unit;
    options[k] = (swp_proxy_options){{1, ~0U}, k % 2 == 0 ? SWP_PROXY_STATIC : 0U, 0, 0};
  }
  swp_proxies* proxies = NULL;
  CHECK_OK(swp_proxies_create(NULL, &proxies));
  CHECK_OK(swp_proxies_add_many(proxies, boxes, options, 2, first));
  counts->is_short = 1;
  counts->allocations_left = allocation_count;
  const swp_result result = swp_proxies_add_many(proxies, boxes, options, kMany, added);
  counts->is_short = 0;
  uint32_t moving_count = 0;
  uint32_t static_count = 0;
  CHECK_OK(swp_proxies_counts(proxies, &moving_count, &static_count, NULL));
  CHECK(moving_count == (result == SWP_OK ? 1 + kMany / 2 : 1));
  CHECK(static_count == moving_count);
  CHECK_OK(swp_proxies_remove_many(proxies, first, 2));
  swp_proxies_destroy(proxies);
  return result;
}

/* Whichever allocation fails, nothing was added. */
static void check_add_without_memory(seen* counts) {
  uint64_t allocation_count = 0;
  while (add_short_of_memory(counts, allocation_count) == SWP_RESOURCE_EXHAUSTED) {
    ++allocation_count;
  }
  CHECK(allocation_count > 2);
}

/* The hooks cannot change while an object exists. A world that was not built holds no memory
 * from the hooks, but its threads use them. */
static void check_beside_an_object(void) {
  swp_world* world = NULL;
  CHECK_OK(swp_world_create("SAP", NULL, &world));
  CHECK(swp_set_hooks(NULL) == SWP_FAILED_PRECONDITION);
  swp_world_destroy(world);
  CHECK_OK(swp_set_hooks(NULL));
}

void test_hooks(void) {
  seen counts = {0};
  check_beside_an_object();
  swp_hooks hooks = {.struct_size = sizeof hooks};
  REFUSED(swp_hooks_init(NULL));
  CHECK_OK(swp_hooks_init(&hooks));
  hooks.user = &counts;
  hooks.allocate = allocate;
  REFUSED(swp_set_hooks(&hooks));
  hooks.release = release;
  hooks.zone_begin = begin_zone;
  REFUSED(swp_set_hooks(&hooks));
  hooks.zone_end = end_zone;
  hooks.thread_started = start_thread;
  hooks.reserved = 1;
  REFUSED(swp_set_hooks(&hooks));
  hooks.reserved = 0;
  CHECK_OK(swp_set_hooks(&hooks));
  swp_session* session = make_session(0);
  run_frame(session);
  CHECK(counts.allocation_count > 0);
  CHECK(counts.search_count == 1);
  CHECK(swp_set_hooks(NULL) == SWP_FAILED_PRECONDITION);
  run_frame(session);
  CHECK(counts.search_count == 2);
  CHECK_OK(swp_session_attach_decider(session, NULL, 0));
  CHECK(counts.decide_count == 0);
  CHECK_OK(swp_session_poll_decider(session, 1, NULL, NULL));
  CHECK(counts.decide_count > 0);
  swp_session_destroy(session);
  CHECK(counts.pool_thread_count == 1);
  check_trim(&counts);
  check_budget(&counts);
  if (CATCHES_OUT_OF_MEMORY) {
    check_out_of_memory(&counts);
    check_add_without_memory(&counts);
  }
  CHECK(counts.allocation_count == counts.release_count);
  CHECK(counts.open_zone_count == 0);
  CHECK_OK(swp_set_hooks(NULL));
}
