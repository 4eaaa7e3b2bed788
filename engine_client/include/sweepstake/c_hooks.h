/* The part of the C ABI for hooks. With hooks a game replaces or observes the library's memory,
 * profiling zones and threads. They apply to the whole process. c_api.h includes this header. It
 * mirrors sweepstake/hooks.h, which lists the zones, the threads, and the memory that goes through
 * the hooks.
 *
 * Cost: reading the hooks takes no lock. A zone without hooks costs one load. */
#ifndef SWEEPSTAKE_C_HOOKS_H_
#define SWEEPSTAKE_C_HOOKS_H_

#include <stdint.h>

#include "sweepstake/c_api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

/* A NULL member keeps the default. All functions may be called on any thread, several at a time,
 * and must return normally without calling the library. The pointer of a name never changes and
 * is valid while the library is loaded. */
typedef struct swp_hooks {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  void* user;        /* passed to each function; borrowed until the hooks are replaced */
  /* Returns `bytes` bytes, at least 1, aligned to `alignment`, a power of two up to 64. NULL means
   * that no memory is left; the call then ends with SWP_RESOURCE_EXHAUSTED. */
  void* (*allocate)(uint64_t bytes, uint64_t alignment, void* user);
  /* Frees what `allocate` returned for the same `bytes` and `alignment`. */
  void (*release)(void* pointer, uint64_t bytes, uint64_t alignment, void* user);
  /* Called at the start and the end of a named zone of work. Zones of one thread may be nested. */
  void (*zone_begin)(const char* name, void* user);
  void (*zone_end)(const char* name, void* user);
  /* Called first on each thread that the library starts, so that affinity and priority can be set.
   * The lane's thread already has a low priority (hooks.h). */
  void (*thread_started)(const char* name, void* user);
  /* Called before a library that was built without exceptions aborts because memory ran out. */
  void (*out_of_memory)(void* user);
} swp_hooks;

/* Sets all hooks to NULL. */
SWP_API swp_result swp_hooks_init(swp_hooks* hooks);

/* Replaces the hooks by a copy of these. NULL restores the defaults. Call it before the first
 * object is made or after the last one is destroyed, while no other thread is in a call.
 * SWP_FAILED_PRECONDITION if any object exists (swp_live_count), because its threads read the
 * hooks. SWP_INVALID_ARGUMENT if only one of `allocate` and `release` is set, or only one of
 * `zone_begin` and `zone_end`. */
SWP_API swp_result swp_set_hooks(const swp_hooks* hooks);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_HOOKS_H_ */
