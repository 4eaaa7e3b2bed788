// How a broad phase spreads one call over several threads: the hook for an engine's own job system.
//
// An engine derives from Executor and hands parts to its jobs; MakeThreadPool is a small pool for
// programs without one. A backend calls RunParts on the thread that called the backend, never from
// inside a part. Ownership: whoever is given an Executor borrows it. Cost: a backend asks for a few
// parts per thread and only where the work is worth it, so that a small scene runs on the calling
// thread alone. The calling thread works too, and then waits for the parts that others have begun.
#pragma once

#include <cstddef>
#include <memory>

namespace sweepstake {

class Executor {
 public:
  // Does not throw. Any thread.
  using RunPart = void (*)(void* context, size_t part);

  virtual ~Executor() = default;

  // Threads that may run parts at the same time, the caller included; at least 1, always the same.
  virtual size_t thread_count() const noexcept = 0;

  // Calls run_part(context, part) once for each part in [0, part_count), at most 65,535, in any
  // order, and returns when all have returned. What a part has written is visible to the caller
  // afterwards. One call at a time per Executor.
  virtual void RunParts(size_t part_count, RunPart run_part, void* context) noexcept = 0;
};

// `thread_count` threads, of which the caller of RunParts is one: 1 starts none. Threads without
// work look for it for some 150 µs and then sleep. REQUIRES: 1 <= thread_count <= 256. Throws
// std::system_error when the system has no more threads.
std::unique_ptr<Executor> MakeThreadPool(size_t thread_count);

}  // namespace sweepstake
