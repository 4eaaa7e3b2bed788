/* Tests every struct with a struct_size: sizes that are shorter, longer or invalid. */
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

static swp_session* session;
static swp_world* world;

/* Calls that read a struct with a struct_size. */

static swp_result take_world_options(void* options) {
  swp_world* made = NULL;
  const swp_result result = swp_world_create("SAP", options, &made);
  swp_world_destroy(made);
  return result;
}

static void run_parts(void* user, uint64_t part_count, swp_run_part run_part, void* job) {
  (void)user;
  for (uint64_t part = 0; part < part_count; ++part) run_part(job, part);
}

static swp_result init_executor(void* executor) {
  const swp_result result = swp_executor_init(executor);
  if (result == SWP_OK) ((swp_executor*)executor)->run_parts = run_parts;
  return result;
}

static swp_result take_executor(void* executor) {
  swp_world_options options = {.struct_size = sizeof options};
  CHECK_OK(swp_world_options_init(&options));
  options.executor = executor;
  return take_world_options(&options);
}

static swp_result take_session_options(void* options) {
  swp_session* made = NULL;
  const swp_result result = swp_session_create(options, &made);
  swp_session_destroy(made);
  return result;
}

static swp_result take_hooks(void* hooks) {
  const swp_result result = swp_set_hooks(hooks);
  if (result == SWP_OK) CHECK_OK(swp_set_hooks(NULL));
  return result;
}

static swp_result take_decider_options(void* options) {
  const swp_result result = swp_session_attach_decider(session, options, 0);
  if (result == SWP_OK) CHECK_OK(swp_session_detach_decider(session));
  return result;
}

static swp_result take_link_options(void* options) {
  swp_link* made = NULL;
  const swp_result result = swp_link_create(session, options, &made);
  swp_link_destroy(made);
  return result;
}

static swp_result take_proxies_options(void* options) {
  swp_proxies* made = NULL;
  const swp_result result = swp_proxies_create(options, &made);
  swp_proxies_destroy(made);
  return result;
}

static swp_result take_scene_options(void* options) {
  swp_scene* made = NULL;
  const swp_result result = swp_scene_create("brownian", options, &made);
  swp_scene_destroy(made);
  return result;
}

/* Calls that fill a struct with a struct_size. */

static swp_result fill_world_options(void* out) { return swp_world_options_init(out); }
static swp_result fill_hooks(void* out) { return swp_hooks_init(out); }
static swp_result fill_executor(void* out) { return swp_executor_init(out); }
static swp_result fill_session_options(void* out) { return swp_session_options_init(out); }
static swp_result fill_decider_options(void* out) { return swp_decider_options_init(out); }
static swp_result fill_link_options(void* out) { return swp_link_options_init(out); }
static swp_result fill_proxies_options(void* out) { return swp_proxies_options_init(out); }
static swp_result fill_scene_options(void* out) { return swp_scene_options_init(out); }
static swp_result fill_counters(void* out) { return swp_world_counters(world, out); }
static swp_result fill_shadow_stats(void* out) { return swp_session_shadow_stats(session, out); }
static swp_result fill_decision(void* out) { return swp_session_last_decision(session, out); }
static swp_result fill_link_stats(void* out) {
  swp_link* link = NULL;
  CHECK_OK(swp_link_create(session, NULL, &link));
  const swp_result result = swp_link_status(link, out);
  swp_link_destroy(link);
  return result;
}

typedef struct output_struct {
  uint32_t size;
  swp_result (*fill)(void* out);
} output_struct;

static const options_struct kOptions[] = {
    {sizeof(swp_world_options), fill_world_options, take_world_options},
    {sizeof(swp_executor), init_executor, take_executor},
    {sizeof(swp_session_options), fill_session_options, take_session_options},
    {sizeof(swp_decider_options), fill_decider_options, take_decider_options},
    {sizeof(swp_link_options), fill_link_options, take_link_options},
    {sizeof(swp_proxies_options), fill_proxies_options, take_proxies_options},
    {sizeof(swp_scene_options), fill_scene_options, take_scene_options},
};

/* swp_hooks can only be set while no object exists. */
static const options_struct kHooks = {sizeof(swp_hooks), fill_hooks, take_hooks};

static const output_struct kOutputs[] = {
    {sizeof(swp_world_options), fill_world_options},
    {sizeof(swp_executor), fill_executor},
    {sizeof(swp_hooks), fill_hooks},
    {sizeof(swp_session_options), fill_session_options},
    {sizeof(swp_decider_options), fill_decider_options},
    {sizeof(swp_link_options), fill_link_options},
    {sizeof(swp_proxies_options), fill_proxies_options},
    {sizeof(swp_scene_options), fill_scene_options},
    {sizeof(swp_counters), fill_counters},
    {sizeof(swp_shadow_stats), fill_shadow_stats},
    {sizeof(swp_decision), fill_decision},
    {sizeof(swp_link_stats), fill_link_stats},
};

/* Allocates exactly this size, so that a sanitizer reports an access beyond it. */
static unsigned char* make_struct(uint32_t bytes, uint32_t struct_size, int filler) {
  unsigned char* made = malloc(bytes);
  if (made == NULL) abort();
  memset(made, filler, bytes);
  memcpy(made, &struct_size, sizeof struct_size);
  return made;
}

static void refuse_sizes(uint32_t size, swp_result (*call)(void*)) {
  const uint32_t wrong[] = {0, 4, size - 4, size - 1, 4097, 0xffffffffU};
  for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
    unsigned char* short_one = make_struct(sizeof(uint32_t), wrong[i], 0);
    CHECK(call(short_one) == SWP_INVALID_ARGUMENT);
    CHECK(strstr(swp_last_error(), "struct_size of swp_") != NULL);
    free(short_one);
  }
}

void check_taken(const options_struct* type) {
  const uint32_t longer = type->size + 24;
  unsigned char* options = make_struct(longer, longer, 0);
  refuse_sizes(type->size, type->take);
  CHECK_OK(type->init(options));
  CHECK_OK(type->take(options));
  for (uint32_t byte = type->size; byte < longer; ++byte) {
    options[byte] = 1;
    CHECK(type->take(options) == SWP_INVALID_ARGUMENT);
    CHECK(strstr(swp_last_error(), "does not know") != NULL);
    options[byte] = 0;
  }
  CHECK_OK(type->take(options));
  free(options);
}

static void check_filled(const output_struct* type) {
  const uint32_t longer = type->size + 24;
  unsigned char* exact = make_struct(type->size, type->size, 0xee);
  unsigned char* large = make_struct(longer, longer, 0xee);
  uint32_t size = 0;
  refuse_sizes(type->size, type->fill);
  CHECK(type->fill(NULL) == SWP_INVALID_ARGUMENT);
  CHECK_OK(type->fill(exact));
  CHECK_OK(type->fill(large));
  memcpy(&size, large, sizeof size);
  CHECK(size == longer);
  CHECK(memcmp(exact + 4, large + 4, type->size - 4) == 0);
  for (uint32_t byte = type->size; byte < longer; ++byte) CHECK(large[byte] == 0);
  free(exact);
  free(large);
}

void test_structs(void) {
  check_taken(&kHooks);
  CHECK_OK(swp_session_create(NULL, &session));
  CHECK_OK(swp_world_create("SAP", NULL, &world));
  for (size_t i = 0; i < sizeof kOptions / sizeof kOptions[0]; ++i) check_taken(&kOptions[i]);
  for (size_t i = 0; i < sizeof kOutputs / sizeof kOutputs[0]; ++i) check_filled(&kOutputs[i]);
  swp_session_destroy(session);
  swp_world_destroy(world);
}
