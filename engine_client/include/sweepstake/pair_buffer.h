// A growing array of overlap pairs, which a caller keeps between frames so that a steady scene
// allocates nothing. Not thread-safe. Memory grows by doubling and is kept until destruction.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>

#include "sweepstake/aabb.h"

namespace sweepstake {

class PairBuffer {
 public:
  // The number of pairs that may be written behind the room that EnsureRoom has made: a vector
  // store may overrun it by one register.
  static constexpr size_t kSlack = 64;

  PairBuffer() = default;
  // A move swaps the two buffers: the other one stays usable, and is empty if this one was new.
  PairBuffer(PairBuffer&& other) noexcept { *this = std::move(other); }
  PairBuffer& operator=(PairBuffer&& other) noexcept {
    std::swap(storage_, other.storage_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::span<const OverlapPair> pairs() const { return {storage_.get(), size_}; }
  std::span<OverlapPair> pairs() { return {storage_.get(), size_}; }
  void Clear() { size_ = 0; }
  // Keeps the first `size` pairs. REQUIRES: size <= size().
  void Truncate(size_t size) { size_ = size; }
  size_t capacity_bytes() const {
    return (capacity_ + (capacity_ ? kSlack : 0)) * sizeof(OverlapPair);
  }

  void Append(OverlapPair pair) {
    *EnsureRoom(1) = pair;
    ++size_;
  }

  // Makes room for `count` more pairs plus kSlack, and returns the end of the array, where they
  // belong. The caller writes them and calls Advance with their number. Throws std::bad_alloc if
  // memory runs out; the content is then unchanged.
  OverlapPair* EnsureRoom(size_t count) {
    if (size_ + count > capacity_ || !storage_) Grow(size_ + count);
    return storage_.get() + size_;
  }
  void Advance(size_t count) { size_ += count; }

 private:
  struct Free {
    void operator()(OverlapPair* pointer) const { std::free(pointer); }
  };

  void Grow(size_t needed) {
    size_t capacity = capacity_ < 512 ? 1024 : capacity_ * 2;
    if (capacity < needed) capacity = needed;
    void* moved = std::realloc(storage_.get(), (capacity + kSlack) * sizeof(OverlapPair));
    if (moved == nullptr) throw std::bad_alloc();
    (void)storage_.release();
    storage_.reset(static_cast<OverlapPair*>(moved));
    capacity_ = capacity;
  }

  std::unique_ptr<OverlapPair[], Free> storage_;
  size_t size_ = 0;
  size_t capacity_ = 0;
};

}  // namespace sweepstake
