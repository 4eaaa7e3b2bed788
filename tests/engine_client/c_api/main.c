/* Runs the test that the command line names. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

int failure_count = 0;

static int overlap(const swp_aabb* a, const swp_aabb* b) {
  for (int axis = 0; axis < 3; ++axis) {
    /* This form of the test finds no overlap if a coordinate is NaN. */
    if (!(a->min[axis] <= b->max[axis] && b->min[axis] <= a->max[axis])) return 0;
  }
  return 1;
}

static int is_valid(const swp_aabb* box) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!isfinite(box->min[axis]) || !isfinite(box->max[axis])) return 0;
    if (box->min[axis] > box->max[axis]) return 0;
  }
  return 1;
}

swp_pair* brute_force(const swp_aabb* boxes, uint32_t count, uint64_t* pair_count) {
  uint64_t capacity = 1024;
  swp_pair* pairs = malloc(capacity * sizeof *pairs);
  *pair_count = 0;
  for (uint32_t a = 0; a < count; ++a) {
    for (uint32_t b = a + 1; b < count; ++b) {
      if (!is_valid(&boxes[a]) || !is_valid(&boxes[b]) || !overlap(&boxes[a], &boxes[b])) {
        continue;
      }
      if (*pair_count == capacity) {
        capacity *= 2;
        pairs = realloc(pairs, capacity * sizeof *pairs);
      }
      if (pairs == NULL) abort();
      pairs[*pair_count].a = a;
      pairs[*pair_count].b = b;
      ++*pair_count;
    }
  }
  return pairs;
}

swp_pair* copy_pairs(const swp_pair* pairs, uint64_t count) {
  swp_pair* copy = malloc((count + 1) * sizeof *copy);
  if (copy == NULL) abort();
  if (count > 0) memcpy(copy, pairs, count * sizeof *copy);
  return copy;
}

static int compare_pairs(const void* left, const void* right) {
  const swp_pair* a = left;
  const swp_pair* b = right;
  if (a->a != b->a) return a->a < b->a ? -1 : 1;
  return a->b < b->b ? -1 : a->b > b->b;
}

int same_pairs(swp_pair* found, uint64_t found_count, const swp_pair* right, uint64_t right_count) {
  if (found_count != right_count) return 0;
  if (found_count == 0) return 1;
  qsort(found, found_count, sizeof *found, compare_pairs);
  return memcmp(found, right, found_count * sizeof *found) == 0;
}

swp_scene* make_scene(const char* name, uint32_t object_count) {
  swp_scene_options options = {.struct_size = sizeof options};
  swp_scene* scene = NULL;
  swp_scene_options_init(&options);
  options.object_count = object_count;
  if (swp_scene_create(name, &options, &scene) != SWP_OK) {
    fprintf(stderr, "no scene: %s\n", swp_last_error());
    exit(1);
  }
  return scene;
}

int main(int argc, char** argv) {
  static const struct {
    const char* name;
    void (*run)(void);
  } tests[] = {
      {"version", test_version}, {"worlds", test_worlds},       {"world_rules", test_world_rules},
      {"threads", test_threads}, {"proxies", test_proxies},     {"scenes", test_scenes},
      {"frames", test_frames},   {"queue", test_queue},         {"decider", test_decider},
      {"structs", test_structs}, {"arguments", test_arguments}, {"link", test_link},
      {"hooks", test_hooks},
  };
  for (size_t i = 0; argc == 2 && i < sizeof tests / sizeof tests[0]; ++i) {
    if (strcmp(tests[i].name, argv[1]) != 0) continue;
    tests[i].run();
    return failure_count == 0 ? 0 : 1;
  }
  fprintf(stderr, "no such test\n");
  return 2;
}
