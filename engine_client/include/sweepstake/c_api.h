/* The C ABI of Sweepstake, which Unity and other engines load from the shared library `sweepstake`.
 * This header has the rules for the whole ABI, and includes one header per topic: c_hooks.h,
 * c_worlds.h, c_sessions.h, c_deciders.h, c_link.h, c_proxies.h and c_scenes.h. c_daemon.h belongs
 * to a library of its own and is included separately.
 *
 * Threads: distinct objects are independent. An object has one caller at a time. A call may begin
 * only after the object's previous call has returned; the two may be on different threads. "The
 * frame thread" of a session means one caller at a time, not one thread of the operating system. A
 * job may make a call on any worker, and the next job on another. Comments state where two calls
 * may run at the same time. The library calls back only into a caller's executor, to run parts of a
 * search, and into hooks that were set (c_hooks.h).
 *
 * Ownership: the object that a _create function returns is ended by the matching _destroy, which
 * accepts NULL as free() does. Using it afterwards is undefined. A forked child process may destroy
 * its parent's objects, and do nothing else with them. Memory that a function returns belongs to
 * the library and is valid as long as its comment says.
 *
 * Units: lengths are in world units of the caller, times in nanoseconds, text is UTF-8 and ends
 * with NUL. Truth values are uint32_t, 0 or 1. Only scalars and pointers are passed by value.
 *
 * Structs: if the first member is struct_size, set it to sizeof the struct before any call that
 * takes the struct, including the _init functions:
 *
 *   swp_world_options options = {.struct_size = sizeof options};
 *   swp_world_options_init(&options);
 *   options.sorted_pairs = 1;
 *
 * Such a struct may grow at its end, and the library never reads or writes beyond struct_size. It
 * accepts the sizes of earlier revisions, with defaults for the missing members. It also accepts
 * larger sizes if the additional bytes are zero. Structs that the library fills are cut, or padded
 * with zeros. Structs without struct_size (boxes, pairs, rays, hits, samples, filters and other
 * elements of arrays) never change.
 *
 * Floating point: the library computes in the default environment: it rounds to nearest, keeps
 * subnormal numbers and traps no exception. It restores the caller's environment on return.
 * Callbacks run in the library's.
 *
 * Errors: functions return a swp_result. If it is not SWP_OK, swp_last_error() says what to do.
 * NULL for a required pointer is SWP_INVALID_ARGUMENT. A function that fails leaves its outputs
 * unchanged, unless its comment says otherwise. No exception leaves the library. */
#ifndef SWEEPSTAKE_C_API_H_
#define SWEEPSTAKE_C_API_H_

#include <stdint.h>

#if UINTPTR_MAX < UINT64_MAX
#error "Sweepstake needs a 64-bit target"
#endif

/* A program that links the archive (sweepstake_static) defines SWP_STATIC. A program that links or
 * loads the shared library defines nothing. A shared library that links the archive does not export
 * the archive's functions. */
#if defined(SWP_STATIC)
#define SWP_API
#elif !defined(_WIN32)
#define SWP_API __attribute__((visibility("default")))
#elif defined(SWP_BUILDING_LIBRARY)
#define SWP_API __declspec(dllexport)
#else
#define SWP_API __declspec(dllimport)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

/* Incremented by every change that an already compiled caller could notice. No such change is
 * planned. */
#define SWP_ABI_VERSION 3U
/* Number of additions to this ABI version: new functions, new values, and new fields at the end
 * of structs that have a struct_size. */
#define SWP_ABI_REVISION 0U

/* ---- results ---- */

typedef int32_t swp_result;
enum {
  SWP_OK = 0,
  SWP_INVALID_ARGUMENT = 1,    /* a value of the caller is wrong */
  SWP_NOT_FOUND = 2,           /* no such file, name or proxy */
  SWP_DATA_LOSS = 3,           /* a file exists and its content is broken */
  SWP_UNAVAILABLE = 4,         /* something cannot be reached; trying again may help */
  SWP_RESOURCE_EXHAUSTED = 5,  /* a buffer is too small, a bound was hit, or memory ran out */
  SWP_FAILED_PRECONDITION = 6, /* calls in the wrong order */
  SWP_INTERNAL = 7             /* a bug in the library */
};

/* One line about the latest failed call on this thread, "" if none has failed. Valid until the next
 * failure on this thread. */
SWP_API const char* swp_last_error(void);
/* Sets swp_last_error() of this thread to a text of `size` bytes, cut to 1,023. It is for libraries
 * that add functions to the ABI, such as that of c_daemon.h. */
SWP_API void swp_set_last_error(const char* text, uint64_t size);

/* Writes one line about the latest failed call of one object, on whichever thread it ran: jobs
 * migrate between threads. It is "" if no call has failed. It is cut to 255 bytes and to
 * `capacity`, including its NUL. Any thread, any time; it takes a lock that no frame takes.
 * SWP_NOT_FOUND if the object does not exist. If two calls of the object fail at the same moment,
 * one of the two messages is returned.
 */
SWP_API swp_result swp_last_error_of(const void* object, char* text, uint32_t capacity);

/* ---- hosts that lose their handles ---- */

typedef uint32_t swp_kind;
enum {
  SWP_KIND_ANY = 0,
  SWP_KIND_WORLD = 1,
  SWP_KIND_SESSION = 2,
  SWP_KIND_PROXIES = 3,
  SWP_KIND_SCENE = 4,
  SWP_KIND_LINK = 5
};

/* The number of living objects of this kind in the process, or 0 for an unknown kind. Any
 * thread, at any time. */
SWP_API uint32_t swp_live_count(swp_kind kind);

/* Ends every object of the process, with its threads and memory. It is for a host that has lost
 * its handles because its domain was reloaded. Call it before new objects are made.
 *
 * From then on, calls on old objects fail with SWP_FAILED_PRECONDITION. The function waits at
 * most deadline_ms for calls in progress; with 0 it does not wait. Freeing takes additional
 * time, although a session's lane stops in the middle of a search. SWP_UNAVAILABLE: some calls
 * had not returned at the deadline. Their objects stay alive and everything else is freed; call
 * the function again to free the rest. Objects made during the call stay alive.
 *
 * Safe: any thread may call it, at any time and more than once, also while other threads are in
 * calls that take an object as non-const. An old handle that is used afterwards gives
 * SWP_FAILED_PRECONDITION in any function, on any thread. It may be passed to its _destroy once;
 * until then it keeps a small block of memory.
 *
 * Not safe on another thread while this function runs: a _destroy, a call that takes its object
 * as const (to read pairs or query proxies), reading memory that an object has returned, and
 * using a destroyed handle. After SWP_OK the caller's executors are not called any more. */
SWP_API swp_result swp_shutdown_all(uint32_t deadline_ms);

/* ---- version ---- */

/* SWP_ABI_VERSION of the loaded library. Compare it before anything else: a library with another
 * version is incompatible. */
SWP_API uint32_t swp_abi_version(void);
/* SWP_ABI_REVISION of the loaded library. Check it before calling a function that an earlier
 * revision lacks. Apart from that, callers and libraries of different revisions are compatible. */
SWP_API uint32_t swp_abi_revision(void);
/* The version of the library, for display. Programs compare the two numbers above instead. */
SWP_API swp_result swp_version(uint32_t* major, uint32_t* minor, uint32_t* patch);

typedef uint32_t swp_struct;
enum {
  SWP_STRUCT_AABB = 1,
  SWP_STRUCT_PAIR = 2,
  SWP_STRUCT_EXECUTOR = 3,
  SWP_STRUCT_WORLD_OPTIONS = 4,
  SWP_STRUCT_COUNTERS = 5,
  SWP_STRUCT_SESSION_OPTIONS = 6,
  SWP_STRUCT_FRAME_SAMPLE = 7,
  SWP_STRUCT_SWITCH_COMMAND = 8,
  SWP_STRUCT_SWITCH_OUTCOME = 9,
  SWP_STRUCT_SHADOW_STATS = 10,
  SWP_STRUCT_VERDICT = 11,
  SWP_STRUCT_DECIDER_OPTIONS = 12,
  SWP_STRUCT_BELIEF = 13,
  SWP_STRUCT_PROXIES_OPTIONS = 14,
  SWP_STRUCT_FILTER = 15,
  SWP_STRUCT_PROXY_OPTIONS = 16,
  SWP_STRUCT_PROXY_PAIR = 17,
  SWP_STRUCT_RAY = 18,
  SWP_STRUCT_RAY_HIT = 19,
  SWP_STRUCT_SCENE_OPTIONS = 20,
  SWP_STRUCT_LINK_OPTIONS = 21,
  SWP_STRUCT_LINK_STATS = 22,
  SWP_STRUCT_DECISION = 23,
  SWP_STRUCT_SPHERE = 24,
  SWP_STRUCT_BOX_SWEEP = 25,
  SWP_STRUCT_HOOKS = 26,
  SWP_STRUCT_DAEMON_OPTIONS = 27,
  SWP_STRUCT_REWARD_WEIGHTS = 28
};

/* The size in bytes of a struct in this library, for bindings of other languages; 0 for an unknown
 * struct. */
SWP_API uint32_t swp_struct_size(swp_struct which);

/* ---- boxes and pairs ---- */

/* A box is valid when all coordinates are finite and min <= max on each axis. An invalid box
 * overlaps nothing; samples and counters report their number. For an object without bounds, such as
 * a plane, use huge finite faces: a box from -1e30 to 1e30 on an axis overlaps everything on it,
 * with every backend. */
typedef struct swp_aabb {
  float min[3];
  float max[3];
} swp_aabb;

/* Two objects, by index in the array of boxes; a < b. */
typedef struct swp_pair {
  uint32_t a;
  uint32_t b;
} swp_pair;

/* ---- threads: large searches in parts ---- */

/* Runs one part of a search on any thread of the caller. Needs at most 48 KiB of stack. */
typedef void (*swp_run_part)(void* job, uint64_t part);

/* The caller's own job system. Call swp_executor_init, then set run_parts. The object that gets the
 * executor copies it; what `user` points to must outlive that object. */
typedef struct swp_executor {
  uint32_t struct_size;
  /* The number of threads that may run parts at the same time, the calling one included; 1 to 256.
   */
  uint32_t thread_count;
  /* Calls run_part(job, part) once for each part in [0, part_count), in any order and on any
   * thread. Returns when all have returned. It is called on the thread that is in a call of the
   * library, so that thread should run parts too. It must return normally: no exception and no
   * longjmp may leave it or run_part. */
  void (*run_parts)(void* user, uint64_t part_count, swp_run_part run_part, void* job);
  void* user;
} swp_executor;

/* Sets one thread, and run_parts to NULL. */
SWP_API swp_result swp_executor_init(swp_executor* executor);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

/* Replaces the library's memory functions, and observes its profiling zones and threads. */
#include "sweepstake/c_hooks.h" /* IWYU pragma: export */
/* One backend, driven by hand. */
#include "sweepstake/c_worlds.h" /* IWYU pragma: export */
/* The frame path, which switches between backends. */
#include "sweepstake/c_sessions.h" /* IWYU pragma: export */
/* "AI Decides" without a daemon. */
#include "sweepstake/c_deciders.h" /* IWYU pragma: export */
/* A session with a daemon over the caller's own transport. */
#include "sweepstake/c_link.h" /* IWYU pragma: export */
/* Objects by handle, filters, static objects, pair events and queries. */
#include "sweepstake/c_proxies.h" /* IWYU pragma: export */
/* Scenes of moving boxes, to try a broad phase on. */
#include "sweepstake/c_scenes.h" /* IWYU pragma: export */

#endif /* SWEEPSTAKE_C_API_H_ */
