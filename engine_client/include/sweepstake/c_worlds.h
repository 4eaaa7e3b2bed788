/* The part of the C ABI for worlds: one backend, called directly. c_api.h includes this header and
 * has the rules for threads, ownership, units and results. The functions mirror
 * sweepstake/broad_phase.h. A frame:
 *
 *   swp_world_update(world, boxes, count);  (the first time: swp_world_build)
 *   swp_world_find_pairs(world);
 *   swp_world_pairs(world, &pairs, &pair_count);
 *
 * Threads: a world has one caller at a time; while no call runs, any number of threads may read its
 * pairs.
 *
 * Cost: an update and a search take the backend's time, see engine_client/broad_phase/README.md of
 * the sources. Boxes and pairs are not copied. In steady state nothing allocates. */
/* Included before the guard, so that c_api.h includes its headers in the order of their
 * dependencies. */
#include "sweepstake/c_api.h"

#ifndef SWEEPSTAKE_C_WORLDS_H_
#define SWEEPSTAKE_C_WORLDS_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_world swp_world;

typedef struct swp_world_options {
  uint32_t struct_size;
  /* 0 or 1: only the calling thread searches. 2 to 256: a pool of this many threads searches; it
   * ends with the world. Pairs and their order do not depend on the number of threads. */
  uint32_t thread_count;
  const swp_executor* executor; /* replaces the pool; NULL: none */
  uint32_t sorted_pairs;        /* 1: pairs ascend by a and then b, whatever the backend */
  uint32_t reserved;            /* 0 */
  uint64_t max_pairs; /* the maximum number of pairs of a search; 0: no limit. A search with more
                         ends early with SWP_RESOURCE_EXHAUSTED instead of taking all memory:
                         100,000 boxes in one place have 5 billion pairs (40 GB). Until it ends,
                         each thread may find half a million pairs above the limit. A pair takes 8
                         bytes, and twice that while memory grows */
} swp_world_options;

typedef struct swp_counters {
  uint32_t struct_size;
  uint32_t object_count;
  uint64_t aabb_check_count;  /* checks of the latest build or update, and search */
  uint64_t native_bytes;      /* bytes of the backend's own buffers */
  uint64_t detection_time_ns; /* time of the latest build or update, plus the search */
  uint64_t pair_count;        /* pairs of the latest search; 0 before it */
  uint32_t backend_version;   /* incremented by each change that could alter its cost */
  uint32_t invalid_box_count; /* as in swp_frame_sample; here an update is a frame */
} swp_counters;

/* The number of backends, and the name of each. Names stay valid. The name is NULL if `index` is
 * swp_backend_count() or more. Any thread, at any time. */
SWP_API uint32_t swp_backend_count(void);
SWP_API const char* swp_backend_name(uint32_t index);

/* Sets the defaults: only the calling thread, and pairs in the order of the backend. */
SWP_API swp_result swp_world_options_init(swp_world_options* options);
/* Makes a world without boxes. `options` NULL uses the defaults. The message of SWP_NOT_FOUND lists
 * the backends. SWP_RESOURCE_EXHAUSTED if the system has no more threads. */
SWP_API swp_result swp_world_create(const char* backend, const swp_world_options* options,
                                    swp_world** world);
SWP_API void swp_world_destroy(swp_world* world);

/* Discards all state and sets these boxes, which are read during the call only. `boxes` may be NULL
 * if count is 0. SWP_INVALID_ARGUMENT for more than 2^31 - 1 boxes. After SWP_RESOURCE_EXHAUSTED
 * (memory) the world must be built again. */
SWP_API swp_result swp_world_build(swp_world* world, const swp_aabb* boxes, uint32_t count);

/* Sets the boxes of the next frame. A larger count adds objects after the last one, a smaller one
 * removes the last ones; the others keep their ids. SWP_FAILED_PRECONDITION before a build. */
SWP_API swp_result swp_world_update(swp_world* world, const swp_aabb* boxes, uint32_t count);

/* Finds each overlapping pair. A second call without a build or update in between does nothing.
 * SWP_FAILED_PRECONDITION before a build. After SWP_RESOURCE_EXHAUSTED (memory, or more pairs than
 * max_pairs) there are no pairs, and the world must be built again. */
SWP_API swp_result swp_world_find_pairs(swp_world* world);
/* Writes the pairs of the search, each once. They are in the library's memory, which any thread
 * may read until the next build or update. SWP_FAILED_PRECONDITION before the search. */
SWP_API swp_result swp_world_pairs(const swp_world* world, const swp_pair** pairs, uint64_t* count);

/* The counters of the latest build or update and search, and the memory that the world holds. */
SWP_API swp_result swp_world_counters(const swp_world* world, swp_counters* counters);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_WORLDS_H_ */
