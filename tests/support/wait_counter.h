// Counts calls that could block a thread: locks, waits, wake-ups, sleeps, yields, and input and
// output. It intercepts the C library's functions in programs that have wait_counter.cc among their
// sources, also for calls from shared libraries. A system call inside the C library itself (an
// allocator's futex) is not counted, so count allocations too.
//
//   WaitCounter waits;                  // counts on this thread from here on
//   ... one frame ...
//   EXPECT_EQ(waits.count(), 0) << waits.last_call();
//
// Thread safety: each counter counts the calls of the thread that created it, while it exists. A
// thread may have only one counter at a time.
#pragma once

#include <cstdint>

namespace sweepstake::test_support {

class WaitCounter {
 public:
  WaitCounter();
  ~WaitCounter();
  WaitCounter(const WaitCounter&) = delete;
  WaitCounter& operator=(const WaitCounter&) = delete;

  // Returns false in programs with ThreadSanitizer, where nothing is counted.
  static bool Works();

  uint64_t count() const;
  // Returns the name of the latest counted function; empty if there is none.
  const char* last_call() const;
};

}  // namespace sweepstake::test_support
