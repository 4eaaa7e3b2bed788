// Hooks by which a game replaces or observes the library's memory, profiling zones and threads.
//
// The hooks apply to the whole process. Set them once, before the first object of the library is
// made. A null member keeps the default. Reading them takes no lock; a zone without hooks costs one
// relaxed load.
//
// Memory that grows with the number of boxes, proxies or pairs goes through `allocate` and
// `release`: the buffers of backends, proxies, PairBuffer, and the shadow lane's copies and
// structures. In a steady scene neither is called. Everything else uses operator new, which a
// program may replace too: the objects themselves, options, names, a session's queue and messages,
// the decider, scenes and files. Results written to a caller's std::vector use that vector's
// allocator.
//
// The zones of a frame in their order, then the zones of other threads:
//
//   sweepstake: begin frame       AdaptiveBroadPhase::BeginFrame, with a switch if one is pending
//   sweepstake: update            the active backend builds or takes the boxes
//   sweepstake: search            the active backend finds the pairs
//   sweepstake: resolve proxies   ProxySet::Resolve
//   sweepstake: lane visit        the shadow lane measures an arm
//   sweepstake: lane preparation  the shadow lane updates the arm of the next switch
//   sweepstake: decide            a decider takes samples, or decides
//
// Out of memory: if `allocate` returns null, the call ends as described at OutOfMemory().
#pragma once

#include <cstddef>

#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

// All functions may be called on any thread, several at a time. They must not throw or call the
// library. `user` is the value of Hooks::user.
struct Hooks {
  void* user = nullptr;  // borrowed until the hooks are replaced

  // Returns `bytes` bytes, at least 1, aligned to `alignment`, a power of two up to 64. Null means
  // that no memory is left. Default: operator new.
  void* (*allocate)(size_t bytes, size_t alignment, void* user) = nullptr;
  // Frees what `allocate` returned for the same `bytes` and `alignment`.
  void (*release)(void* pointer, size_t bytes, size_t alignment, void* user) = nullptr;

  // Called at the start and the end of a named zone of work, for a profiler. Zones of one thread
  // may be nested. `name` is one of the names above, which stay the same in later versions. Its
  // pointer never changes and is valid while the library is loaded.
  void (*zone_begin)(const char* name, void* user) = nullptr;
  void (*zone_end)(const char* name, void* user) = nullptr;

  // Called first on each thread that the library starts, so that a game can set affinity and
  // priority and register the thread with a profiler. Names: "swp lane" (the shadow lane), "swp
  // pool" (MakeThreadPool), "swp session" (a session's own). The library has already set this name,
  // if the system supports names. It has also given the lane a low priority, so that other threads
  // go first on its core (Linux: nice plus 10; Windows: lowest; Apple: QOS_CLASS_UTILITY).
  void (*thread_started)(const char* name, void* user) = nullptr;

  // Called before OutOfMemory() aborts, to save a report. Not called if OutOfMemory() throws.
  void (*out_of_memory)(void* user) = nullptr;
};

// Replaces the hooks; Hooks{} restores the defaults. kInvalidArgument: only one of `allocate` and
// `release`, or of `zone_begin` and `zone_end`, is set. kFailedPrecondition: an object holds memory
// from the present hooks. REQUIRES: no other thread uses the library.
Status SetHooks(const Hooks& hooks);

// Allocates memory as the library itself does, for code that must use the same memory. Never
// returns null; if memory runs out, it ends as described at OutOfMemory(). `bytes` 0 counts as 1.
// Any thread.
void* AllocateMemory(size_t bytes, size_t alignment);
// Frees memory of AllocateMemory, with the same `bytes` and `alignment`. `pointer` may be null. Any
// thread.
void ReleaseMemory(void* pointer, size_t bytes, size_t alignment) noexcept;

// Ends a call that needs memory when none is left. A library built with exceptions throws
// std::bad_alloc, which the C ABI converts to SWP_RESOURCE_EXHAUSTED. A library built without them
// (the CMake option SWEEPSTAKE_EXCEPTIONS is OFF) calls Hooks::out_of_memory, writes a line to
// stderr, and aborts.
[[noreturn]] void OutOfMemory();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
