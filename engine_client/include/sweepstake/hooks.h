// Where a game takes part in what the library does for itself: memory, profiling zones, threads.
//
// The hooks count for the whole process and are set once, before the first object of the library is
// made. A null member leaves the default. Reading them takes no lock; a zone without hooks costs
// one relaxed load.
//
// Memory: whatever grows with the number of boxes, proxies or pairs goes through `allocate` and
// `release`: the buffers of backends, proxies, PairBuffer, and the shadow lane's copies and
// structures. In a steady scene neither is called. What does not grow with the scene stays with
// operator new, which a program may replace as well: the objects themselves, options, names, the
// queue and messages of a session, the decider, scenes and files; so do results that the caller's
// own std::vector receives.
//
// Zones, in the order of a frame, then those of other threads:
//
//   sweepstake: begin frame       AdaptiveBroadPhase::BeginFrame, with a switch if one is pending
//   sweepstake: update            the active backend builds or takes the boxes
//   sweepstake: search            it finds the pairs
//   sweepstake: resolve proxies   ProxySet::Resolve
//   sweepstake: lane visit        the shadow lane measures an arm
//   sweepstake: lane preparation  it processes a frame for a switch
//   sweepstake: decide            a decider takes samples, or decides
//
// Out of memory: if `allocate` returns null, the call ends as OutOfMemory() says.
#pragma once

#include <cstddef>

#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

// All functions may be called on any thread, several at a time, and must not throw or call the
// library. `user` is Hooks::user.
struct Hooks {
  void* user = nullptr;  // borrowed until the hooks are replaced

  // Returns `bytes` bytes, at least 1, aligned to `alignment`, a power of two up to 64; null: there
  // is no memory. Default: operator new.
  void* (*allocate)(size_t bytes, size_t alignment, void* user) = nullptr;
  // Takes back what `allocate` returned for the same `bytes` and `alignment`.
  void (*release)(void* pointer, size_t bytes, size_t alignment, void* user) = nullptr;

  // The begin and the end of a named stretch of work, for a profiler. Zones of one thread nest.
  // `name` is one of those above; it stays the same in later versions, is the same pointer each
  // time, and lives as long as the library.
  void (*zone_begin)(const char* name, void* user) = nullptr;
  void (*zone_end)(const char* name, void* user) = nullptr;

  // Called first on each thread that the library starts, where a game sets its affinity and
  // priority and tells a profiler: "swp lane" (the shadow lane), "swp pool" (MakeThreadPool), "swp
  // session" (a session's own). The library has given it that name already, where the system has
  // names, and the lane a low priority: a thread that has to share its core goes first (Linux: nice
  // plus 10; Windows: lowest; Apple: QOS_CLASS_UTILITY).
  void (*thread_started)(const char* name, void* user) = nullptr;

  // Called before OutOfMemory() aborts, to save a report. Not called where it throws.
  void (*out_of_memory)(void* user) = nullptr;
};

// Replaces the hooks; Hooks{} restores the defaults. kInvalidArgument: of `allocate` and `release`,
// or of `zone_begin` and `zone_end`, one alone is null; kFailedPrecondition: an object holds memory
// that the present hooks gave. REQUIRES: no other thread uses the library.
Status SetHooks(const Hooks& hooks);

// What the library itself allocates with, for code that wants its memory in the same place. Never
// returns null, and ends as OutOfMemory() says instead. A `bytes` of 0 counts as 1. Any thread.
void* AllocateMemory(size_t bytes, size_t alignment);
// `pointer` may be null. Any thread.
void ReleaseMemory(void* pointer, size_t bytes, size_t alignment) noexcept;

// Ends a call for which there is no memory. A library built with exceptions throws std::bad_alloc,
// which the C ABI turns into SWP_RESOURCE_EXHAUSTED. One built without (the CMake option
// SWEEPSTAKE_EXCEPTIONS is OFF) calls Hooks::out_of_memory, writes a line to stderr, and aborts.
[[noreturn]] void OutOfMemory();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
