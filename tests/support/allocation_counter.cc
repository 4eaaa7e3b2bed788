#include "tests/support/allocation_counter.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

thread_local constinit uint64_t thread_allocation_count = 0;

void* CountedAllocation(size_t bytes) noexcept {
  ++thread_allocation_count;
  return std::malloc(bytes == 0 ? 1 : bytes);
}

#ifdef _WIN32

// The Windows runtime has its own aligned functions, whose memory must be freed by a matching one.
void* AlignedAllocation(size_t bytes, size_t alignment) {
  return _aligned_malloc(bytes == 0 ? 1 : bytes, alignment);
}
void AlignedFree(void* memory) { _aligned_free(memory); }

#else

// aligned_alloc requires a multiple of the alignment.
void* AlignedAllocation(size_t bytes, size_t alignment) {
  return std::aligned_alloc(alignment, (bytes + alignment) / alignment * alignment);
}
void AlignedFree(void* memory) { std::free(memory); }

#endif

void* CountedAllocation(size_t bytes, std::align_val_t alignment) noexcept {
  ++thread_allocation_count;
  return AlignedAllocation(bytes, static_cast<size_t>(alignment));
}

void* OrThrow(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

namespace sweepstake::test_support {

uint64_t ThreadAllocationCount() { return thread_allocation_count; }

}  // namespace sweepstake::test_support

void* operator new(size_t bytes) { return OrThrow(CountedAllocation(bytes)); }
void* operator new[](size_t bytes) { return OrThrow(CountedAllocation(bytes)); }
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  return CountedAllocation(bytes);
}
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept {
  return CountedAllocation(bytes);
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  return OrThrow(CountedAllocation(bytes, alignment));
}
void* operator new[](size_t bytes, std::align_val_t alignment) {
  return OrThrow(CountedAllocation(bytes, alignment));
}
void* operator new(size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return CountedAllocation(bytes, alignment);
}
void* operator new[](size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return CountedAllocation(bytes, alignment);
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { AlignedFree(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { AlignedFree(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { AlignedFree(memory); }
void operator delete[](void* memory, size_t, std::align_val_t) noexcept { AlignedFree(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  AlignedFree(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  AlignedFree(memory);
}
