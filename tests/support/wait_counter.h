// Counts what could make a thread wait: calls of locks, waits, wake-ups, sleeps, yields, and input
// and output, by interposing the C library's functions in programs that have wait_counter.cc among
// their sources. Calls from shared libraries are seen too; a system call made inside the C library
// itself (an allocator's futex) is not, so count allocations beside it.
//
//   WaitCounter waits;                  // counts on this thread from here on
//   ... one frame ...
//   EXPECT_EQ(waits.count(), 0) << waits.last_call();
//
// Thread safety: each counter counts the thread that made it, while it lives; one at a time per
// thread.
#pragma once

#include <cstdint>

namespace sweepstake::test_support {

class WaitCounter {
 public:
  WaitCounter();
  ~WaitCounter();
  WaitCounter(const WaitCounter&) = delete;
  WaitCounter& operator=(const WaitCounter&) = delete;

  // False in programs with ThreadSanitizer, where nothing is counted.
  static bool Works();

  uint64_t count() const;
  // Name of the latest counted function; empty: none.
  const char* last_call() const;
};

}  // namespace sweepstake::test_support
