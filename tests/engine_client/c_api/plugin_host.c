/* An engine that loads the plug-in by its file name, uses it on threads, lets it run out of
 * memory and unloads it. It repeats this, as an editor does each time the game is played. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "sweepstake/c_api.h"

static void* library;

static void Require(int holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "not true: %s\n", what);
  exit(1);
}

#define REQUIRE(condition) Require(condition, #condition)

/* Declares a pointer with the name of a function of the C ABI, and loads it from the plug-in. */
#define LOAD(function)                                    \
  __typeof(&function) loaded_##function;                  \
  do {                                                    \
    void* const address = dlsym(library, #function);      \
    REQUIRE(address != NULL);                             \
    memcpy(&loaded_##function, &address, sizeof address); \
  } while (0)

static void FindsPairsOnThreads(void) {
  LOAD(swp_world_options_init);
  LOAD(swp_world_create);
  LOAD(swp_world_build);
  LOAD(swp_world_find_pairs);
  LOAD(swp_world_counters);
  LOAD(swp_world_destroy);
  static swp_aabb boxes[4000]; /* each one touches the next */
  for (int k = 0; k < 4000; ++k) {
    boxes[k] = (swp_aabb){{(float)k, 0, 0}, {(float)k + 1, 1, 1}};
  }
  swp_world_options options = {.struct_size = sizeof options};
  swp_world* world = NULL;
  swp_counters counters = {.struct_size = sizeof counters};
  REQUIRE(loaded_swp_world_options_init(&options) == SWP_OK);
  options.thread_count = 4;
  REQUIRE(loaded_swp_world_create("KDTree", &options, &world) == SWP_OK);
  REQUIRE(loaded_swp_world_build(world, boxes, 4000) == SWP_OK);
  REQUIRE(loaded_swp_world_find_pairs(world) == SWP_OK);
  REQUIRE(loaded_swp_world_counters(world, &counters) == SWP_OK);
  REQUIRE(counters.pair_count == 3999);
  loaded_swp_world_destroy(world);
}

/* An exception inside the plug-in is caught there, with the plug-in's own unwinder. */
static void RunsOutOfMemory(void) {
  LOAD(swp_scene_options_init);
  LOAD(swp_scene_create);
  LOAD(swp_last_error);
  struct rlimit before;
  swp_scene_options options = {.struct_size = sizeof options};
  swp_scene* scene = NULL;
  REQUIRE(loaded_swp_scene_options_init(&options) == SWP_OK);
  options.object_count = 16000000;
  getrlimit(RLIMIT_AS, &before);
  const struct rlimit little = {192U << 20, before.rlim_max};
  REQUIRE(setrlimit(RLIMIT_AS, &little) == 0);
  REQUIRE(loaded_swp_scene_create("brownian", &options, &scene) == SWP_RESOURCE_EXHAUSTED);
  REQUIRE(strstr(loaded_swp_last_error(), "memory") != NULL);
  setrlimit(RLIMIT_AS, &before);
}

/* The plug-in distinguishes a folder and a broken file from a scene, by asking the system for kind
 * and size. */
static void LooksAtFiles(const char* folder, const char* file) {
  LOAD(swp_scene_create);
  swp_scene* scene = NULL;
  REQUIRE(loaded_swp_scene_create(folder, NULL, &scene) != SWP_OK);
  REQUIRE(loaded_swp_scene_create(file, NULL, &scene) == SWP_DATA_LOSS);
}

int main(int argument_count, char** arguments) {
  REQUIRE(argument_count == 4); /* plug-in, folder, broken NAME.aabbs */
  for (int play = 0; play < 3; ++play) {
    library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) fprintf(stderr, "%s\n", dlerror());
    REQUIRE(library != NULL);
    LOAD(swp_abi_version);
    REQUIRE(loaded_swp_abi_version() == SWP_ABI_VERSION);
    FindsPairsOnThreads();
    if (CATCHES_OUT_OF_MEMORY) RunsOutOfMemory();
    LooksAtFiles(arguments[2], arguments[3]);
    REQUIRE(dlclose(library) == 0);
    /* The library is unloaded completely: an editor can build it again and load the new one. */
    REQUIRE(dlopen(arguments[1], RTLD_NOW | RTLD_NOLOAD) == NULL);
  }
  return 0;
}
