// Counts calls of malloc, calloc, realloc and aligned_alloc by our own code, and calls of operator
// new if allocation_counter.cc is among the sources. A program needs malloc_counter.cc among its
// sources and -Wl,--wrap= for each of the four functions, which wraps the calls in everything that
// is linked statically.
//
// Thread safety: each thread has its own count.
#pragma once

#include <cstdint>

namespace sweepstake::test_support {

// Returns the number of calls by this thread since it started.
uint64_t ThreadMallocCount();

}  // namespace sweepstake::test_support
