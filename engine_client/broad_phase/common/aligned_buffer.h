// An array of trivially copyable values that only grows. It is 64-byte aligned, and its new
// elements are uninitialised. All backends store their data in it, so that a steady scene allocates
// nothing and native_bytes() is a sum of capacity_bytes().
//
// Not thread-safe. Owns its memory, which comes from the hooks, until destruction; movable. If
// memory runs out, it calls OutOfMemory (sweepstake/hooks.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "sweepstake/hooks.h"

namespace sweepstake {

template <typename T>
class AlignedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  static constexpr size_t kAlignment = 64;  // one cache line, one AVX-512 register

  AlignedBuffer() = default;
  ~AlignedBuffer() { Release(); }
  // A move swaps the two buffers: the source stays valid, and is empty if the target was new.
  AlignedBuffer(AlignedBuffer&& other) noexcept { *this = std::move(other); }
  AlignedBuffer& operator=(AlignedBuffer&& other) noexcept {
    std::swap(storage_, other.storage_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }

  T* data() { return storage_; }
  const T* data() const { return storage_; }
  T& operator[](size_t index) { return storage_[index]; }
  const T& operator[](size_t index) const { return storage_[index]; }
  size_t capacity() const { return capacity_; }
  size_t capacity_bytes() const { return capacity_ * sizeof(T); }

  // Makes room for `count` elements; the content is lost if the array has to grow.
  void EnsureDiscarding(size_t count) {
    if (count <= capacity_) return;
    const size_t grown = GrownCapacity(count);
    Release();
    storage_ = nullptr;
    capacity_ = 0;
    storage_ = Allocate(grown);
    capacity_ = grown;
  }

  // Makes room for `count` elements; the content is lost if the array has to grow. A growing array
  // reserves a quarter more, so that a count that changes from frame to frame seldom allocates.
  void EnsureWithSpare(size_t count) {
    if (count > capacity_) EnsureDiscarding(count + count / 4 + 2048);
  }

  // Makes room for `count` elements and keeps the first `kept` elements. REQUIRES: kept <=
  // capacity().
  void EnsureKeeping(size_t count, size_t kept) {
    if (count <= capacity_) return;
    const size_t grown = GrownCapacity(count);
    T* const larger = Allocate(grown);
    if (kept > 0) std::memcpy(larger, storage_, kept * sizeof(T));
    Release();
    storage_ = larger;
    capacity_ = grown;
  }

 private:
  // Grows by half, so that a count that rises frame by frame seldom allocates. The first allocation
  // has exactly the requested size.
  size_t GrownCapacity(size_t count) const { return std::max(count, capacity_ + capacity_ / 2); }

  static T* Allocate(size_t count) {
    return static_cast<T*>(AllocateMemory(count * sizeof(T), kAlignment));
  }
  void Release() { ReleaseMemory(storage_, capacity_bytes(), kAlignment); }

  T* storage_ = nullptr;
  size_t capacity_ = 0;
};

}  // namespace sweepstake
