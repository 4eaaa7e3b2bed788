// Counts the calls of global operator new in programs that have allocation_counter.cc among their
// sources, which replaces the operators. malloc and realloc are not counted.
//
//   const uint64_t before = ThreadAllocationCount();
//   ... one frame ...
//   EXPECT_EQ(ThreadAllocationCount(), before);
//
// Thread safety: each thread has its own count.
#pragma once

#include <cstdint>

namespace sweepstake::test_support {

// Returns the number of calls of any form of operator new by this thread since it started.
uint64_t ThreadAllocationCount();

}  // namespace sweepstake::test_support
