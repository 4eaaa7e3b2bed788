/* The part of the C ABI for worlds: one backend, driven by hand; c_api.h includes it and says what
 * holds for all: threads, ownership, units, results. The functions mirror
 * sweepstake/broad_phase.h. A frame:
 *
 *   swp_world_update(world, boxes, count);  (the first time: swp_world_build)
 *   swp_world_find_pairs(world);
 *   swp_world_pairs(world, &pairs, &pair_count);
 *
 * Threads: one caller at a time may use a world; while none does, any number may read its pairs.
 *
 * Cost: an update and a search take what the backend takes, see engine_client/broad_phase/README.md
 * of the sources; boxes and pairs are not copied. In steady state nothing allocates.
 */
/* Before the guard: c_api.h includes the headers in the order in which they need one another. */
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
  /* 0 or 1: the calling thread alone searches; up to 256: with a pool of so many threads, which
   * ends with the world. Neither the pairs nor their order depend on the threads. */
  uint32_t thread_count;
  const swp_executor* executor; /* takes the place of the pool; NULL: none */
  uint32_t sorted_pairs;        /* 1: pairs ascend by a and then b, whatever the backend */
  uint32_t reserved;            /* 0 */
} swp_world_options;

typedef struct swp_counters {
  uint32_t struct_size;
  uint32_t object_count;
  uint64_t aabb_check_count;  /* of the latest build or update and search */
  uint64_t native_bytes;      /* held by the backend's own buffers */
  uint64_t detection_time_ns; /* the latest build or update plus the search */
  uint64_t pair_count;        /* of the latest search; 0 before it */
  uint32_t backend_version;   /* raised by each change that could alter its cost */
  uint32_t reserved;          /* 0 */
} swp_counters;

/* The number of backends, and their names, which are valid for ever; NULL for an index of
 * swp_backend_count() or above. Any thread, any time. */
SWP_API uint32_t swp_backend_count(void);
SWP_API const char* swp_backend_name(uint32_t index);

/* Fills in the defaults: the calling thread alone, and pairs in the order of the backend. */
SWP_API swp_result swp_world_options_init(swp_world_options* options);
/* Makes a world without boxes. `options` NULL takes the defaults. SWP_NOT_FOUND lists the backends;
 * SWP_RESOURCE_EXHAUSTED if the system has no more threads. */
SWP_API swp_result swp_world_create(const char* backend, const swp_world_options* options,
                                    swp_world** world);
SWP_API void swp_world_destroy(swp_world* world);

/* Discards all state and takes these boxes, read during the call only. `boxes` may be NULL if
 * count is 0. SWP_INVALID_ARGUMENT over 2^31 - 1 boxes. After SWP_RESOURCE_EXHAUSTED (memory) the
 * world must be built again. */
SWP_API swp_result swp_world_build(swp_world* world, const swp_aabb* boxes, uint32_t count);

/* Takes the boxes of the next frame. A larger count adds objects behind the last one, a smaller one
 * removes the last ones; the others keep their ids. SWP_FAILED_PRECONDITION before a build. */
SWP_API swp_result swp_world_update(swp_world* world, const swp_aabb* boxes, uint32_t count);

/* Searches for each overlapping pair, once per build or update; a further call does nothing.
 * SWP_FAILED_PRECONDITION before a build. */
SWP_API swp_result swp_world_find_pairs(swp_world* world);
/* The pairs of the search, each once, in the library's memory, where any thread may read them until
 * the next build or update. SWP_FAILED_PRECONDITION before the search. */
SWP_API swp_result swp_world_pairs(const swp_world* world, const swp_pair** pairs, uint64_t* count);

/* What the latest build or update and search took, and what the world holds. */
SWP_API swp_result swp_world_counters(const swp_world* world, swp_counters* counters);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_WORLDS_H_ */
