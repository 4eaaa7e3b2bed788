// A growing array of overlap pairs that a caller keeps over frames, so that a steady scene
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
  // Pairs that may be written past the size after EnsureRoom: a vector store may overrun by one
  // register.
  static constexpr size_t kSlack = 64;

  PairBuffer() = default;
  // The two change places: what was moved from is a sound buffer, an empty one where this was new.
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
  // Keeps the first pairs. REQUIRES: size <= size().
  void Truncate(size_t size) { size_ = size; }
  size_t capacity_bytes() const {
    return (capacity_ + (capacity_ ? kSlack : 0)) * sizeof(OverlapPair);
  }

  void Append(OverlapPair pair) {
    *EnsureRoom(1) = pair;
    ++size_;
  }

  // Room for `count` more pairs plus kSlack, uninitialized, at the returned end of the array.
  // Followed by Advance with the pairs really written. Throws std::bad_alloc when memory is out;
  // the content is then unchanged.
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
