// Counts calls of malloc, calloc, realloc and aligned_alloc made by our own code, and operator
// new's where allocation_counter.cc is among the sources. For programs that have malloc_counter.cc
// among their sources and are linked with -Wl,--wrap= for each of the four, which wraps the calls
// in everything linked statically.
//
// Thread safety: each thread counts its own.
#pragma once

#include <cstdint>

namespace sweepstake::test_support {

// Calls by this thread since it started.
uint64_t ThreadMallocCount();

}  // namespace sweepstake::test_support
