// The interface through which a broad phase spreads one call over several threads, for example
// those of an engine's job system.
//
// An engine derives from Executor and runs the parts in its jobs. MakeThreadPool makes a small pool
// for programs without a job system. A backend calls RunParts on the thread that called the
// backend, never from inside a part. Ownership: an object that is given an Executor borrows it.
// Cost: a backend runs a few parts per thread. In a small scene it does everything on the calling
// thread. The calling thread also runs parts, and then waits for the parts that other threads have
// begun. A part needs at most 48 KiB of stack; the library's own threads have the system's default.
#pragma once

#include <cstddef>
#include <memory>

namespace sweepstake {

class Executor {
 public:
  // Runs one part. It must not throw, and may be called on any thread.
  using RunPart = void (*)(void* context, size_t part);

  virtual ~Executor() = default;

  // Returns the number of threads that may run parts at the same time, the caller included. It is 1
  // or more and never changes.
  virtual size_t thread_count() const noexcept = 0;

  // Calls run_part(context, part) once for each part in [0, part_count), in any order. Returns when
  // all calls have returned; their writes are then visible to the caller. REQUIRES: part_count <=
  // 65,535; one call at a time per Executor.
  virtual void RunParts(size_t part_count, RunPart run_part, void* context) noexcept = 0;
};

// Makes a pool of `thread_count` threads. The caller of RunParts is one of them, so thread_count −
// 1 threads are started. Idle threads spin for a fraction of a millisecond and then sleep. A forked
// child process may destroy the pool, and do nothing else with it.
//
// REQUIRES: 1 <= thread_count <= 256. If the system has no more threads, it throws
// std::system_error, and aborts in a library built without exceptions (hooks.h).
std::unique_ptr<Executor> MakeThreadPool(size_t thread_count);

}  // namespace sweepstake
