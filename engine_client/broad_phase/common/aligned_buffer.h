// An array that only grows: 64-byte aligned, uninitialised, for plain values. The storage of every
// backend, so that a steady scene allocates nothing and native_bytes() is a sum of
// capacity_bytes().
//
// Not thread-safe. Owns its memory until destruction; movable. Throws std::bad_alloc when memory is
// out.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace sweepstake {

template <typename T>
class AlignedBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  static constexpr size_t kAlignment = 64;  // one cache line, one AVX-512 register

  AlignedBuffer() = default;
  // The two change places: what was moved from is a sound buffer, an empty one where this was new.
  AlignedBuffer(AlignedBuffer&& other) noexcept { *this = std::move(other); }
  AlignedBuffer& operator=(AlignedBuffer&& other) noexcept {
    std::swap(storage_, other.storage_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }

  T* data() { return storage_.get(); }
  const T* data() const { return storage_.get(); }
  T& operator[](size_t index) { return storage_.get()[index]; }
  const T& operator[](size_t index) const { return storage_.get()[index]; }
  size_t capacity() const { return capacity_; }
  size_t capacity_bytes() const { return capacity_ * sizeof(T); }

  // Room for `count` elements; what was inside is lost if the array has to grow.
  void EnsureDiscarding(size_t count) {
    if (count <= capacity_) return;
    const size_t grown = GrownCapacity(count);
    storage_.reset();
    capacity_ = 0;
    storage_ = Allocate(grown);
    capacity_ = grown;
  }

  // The same for a count that wavers from frame to frame: growing takes room for more, or it would
  // take memory again and again.
  void EnsureWithSpare(size_t count) {
    if (count > capacity_) EnsureDiscarding(count + count / 4 + 2048);
  }

  // Room for `count` elements; the first `kept` ones stay. REQUIRES: kept <= capacity().
  void EnsureKeeping(size_t count, size_t kept) {
    if (count <= capacity_) return;
    const size_t grown = GrownCapacity(count);
    Storage larger = Allocate(grown);
    if (kept > 0) std::memcpy(larger.get(), storage_.get(), kept * sizeof(T));
    storage_ = std::move(larger);
    capacity_ = grown;
  }

 private:
  struct Free {
    void operator()(T* pointer) const { ::operator delete (pointer, std::align_val_t{kAlignment}); }
  };
  using Storage = std::unique_ptr<T[], Free>;

  // Half as much again, so that a count rising frame by frame seldom allocates; exact for the first
  // use.
  size_t GrownCapacity(size_t count) const { return std::max(count, capacity_ + capacity_ / 2); }

  static Storage Allocate(size_t count) {
    return Storage(
        static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kAlignment})));
  }

  Storage storage_;
  size_t capacity_ = 0;
};

}  // namespace sweepstake
