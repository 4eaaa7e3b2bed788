/* Shared by the C tests: a check that counts failures, and an independent brute-force search. */
#ifndef SWEEPSTAKE_TESTS_C_API_CHECK_H_
#define SWEEPSTAKE_TESTS_C_API_CHECK_H_

#include <stdio.h>

#include "sweepstake/c_api.h"

extern int failure_count;

#define CHECK(condition)                                                                        \
  do {                                                                                          \
    if (!(condition)) {                                                                         \
      ++failure_count;                                                                          \
      fprintf(stderr, "%s:%d: not true: %s (last error: %s)\n", __FILE__, __LINE__, #condition, \
              swp_last_error());                                                                \
    }                                                                                           \
  } while (0)

#define CHECK_OK(call) CHECK((call) == SWP_OK)

/* Checks that a call with an invalid argument is refused with a message. */
#define REFUSED(call)                      \
  do {                                     \
    CHECK((call) == SWP_INVALID_ARGUMENT); \
    CHECK(swp_last_error()[0] != '\0');    \
  } while (0)

/* Returns all overlapping pairs in ascending order; the caller frees them. */
swp_pair* brute_force(const swp_aabb* boxes, uint32_t count, uint64_t* pair_count);

/* Returns a copy of the pairs, which the caller frees. */
swp_pair* copy_pairs(const swp_pair* pairs, uint64_t count);

/* Returns whether both contain the same pairs; sorts `found`. */
int same_pairs(swp_pair* found, uint64_t found_count, const swp_pair* right, uint64_t right_count);

/* Creates a scene of the library; ends the program if it does not exist. */
swp_scene* make_scene(const char* name, uint32_t object_count);

/* A struct with a struct_size that the library reads. */
typedef struct options_struct {
  uint32_t size;
  swp_result (*init)(void* options);
  swp_result (*take)(void* options);
} options_struct;

/* Checks sizes of the struct that are shorter, longer or invalid. */
void check_taken(const options_struct* type);

void test_version(void);
void test_worlds(void);
void test_world_rules(void);
void test_threads(void);
void test_proxies(void);
void test_scenes(void);
void test_frames(void);
void test_queue(void);
void test_decider(void);
void test_link(void);
void test_daemon(void);
void test_hooks(void);
void test_structs(void);
void test_arguments(void);

#endif
