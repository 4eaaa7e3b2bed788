#include "tests/support/malloc_counter.h"

#include <cstddef>

namespace {

thread_local constinit uint64_t thread_malloc_count = 0;

}  // namespace

namespace sweepstake::test_support {

uint64_t ThreadMallocCount() { return thread_malloc_count; }

}  // namespace sweepstake::test_support

// The linker's --wrap turns calls of f into __wrap_f and provides the real function as __real_f; it
// defines these names. NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __real_malloc(size_t bytes);
void* __real_calloc(size_t count, size_t bytes);
void* __real_realloc(void* memory, size_t bytes);
void* __real_aligned_alloc(size_t alignment, size_t bytes);

void* __wrap_malloc(size_t bytes) {
  ++thread_malloc_count;
  return __real_malloc(bytes);
}
void* __wrap_calloc(size_t count, size_t bytes) {
  ++thread_malloc_count;
  return __real_calloc(count, bytes);
}
void* __wrap_realloc(void* memory, size_t bytes) {
  ++thread_malloc_count;
  return __real_realloc(memory, bytes);
}
void* __wrap_aligned_alloc(size_t alignment, size_t bytes) {
  ++thread_malloc_count;
  return __real_aligned_alloc(alignment, bytes);
}
}
// NOLINTEND(bugprone-reserved-identifier)
