/* The part of the C ABI for hooks: where a game takes part in what the library does for itself.
 * They count for the whole process. c_api.h includes this header; sweepstake/hooks.h, which it
 * mirrors, says what memory goes through the hooks and has the list of zones and threads.
 *
 * Cost: reading the hooks takes no lock, and a zone without hooks one load.
 */
#ifndef SWEEPSTAKE_C_HOOKS_H_
#define SWEEPSTAKE_C_HOOKS_H_

#include <stdint.h>

#include "sweepstake/c_api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

/* A NULL member leaves the default. All functions may be called on any thread, several at a time,
 * and must return normally without calling the library. Names are the same pointers each time and
 * live as long as the library. */
typedef struct swp_hooks {
  uint32_t struct_size;
  uint32_t reserved; /* 0 */
  void* user;        /* handed to each function; borrowed until the hooks are replaced */
  /* Returns `bytes` bytes, at least 1, aligned to `alignment`, a power of two up to 64; NULL: there
   * is no memory, and the call ends with SWP_RESOURCE_EXHAUSTED. */
  void* (*allocate)(uint64_t bytes, uint64_t alignment, void* user);
  /* Takes back what `allocate` returned for the same `bytes` and `alignment`. */
  void (*release)(void* pointer, uint64_t bytes, uint64_t alignment, void* user);
  /* The begin and the end of a named stretch of work; those of one thread nest. */
  void (*zone_begin)(const char* name, void* user);
  void (*zone_end)(const char* name, void* user);
  /* Called first on each thread that the library starts, where affinity and priority are set; the
   * lane's has a low priority already (hooks.h). */
  void (*thread_started)(const char* name, void* user);
  /* Called before a library that was built without exceptions aborts for want of memory. */
  void (*out_of_memory)(void* user);
} swp_hooks;

/* Fills in no hooks. */
SWP_API swp_result swp_hooks_init(swp_hooks* hooks);

/* Replaces the hooks by a copy of these; NULL restores the defaults. Call it before the first
 * object is made and after the last is destroyed, while no other thread is in a call:
 * SWP_FAILED_PRECONDITION while an object lives (swp_live_count), since its threads read the hooks.
 * SWP_INVALID_ARGUMENT: of `allocate` and `release`, or of `zone_begin` and `zone_end`, one alone
 * is NULL. */
SWP_API swp_result swp_set_hooks(const swp_hooks* hooks);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_HOOKS_H_ */
