// A growing array of overlap pairs, which a caller keeps between frames so that a steady scene
// allocates nothing. Not thread-safe. Memory grows by doubling, comes from the hooks (hooks.h), and
// is kept until destruction.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "sweepstake/aabb.h"
#include "sweepstake/hooks.h"

namespace sweepstake {

class PairBuffer {
 public:
  // Extra room, in pairs, beyond the count passed to EnsureRoom, because a vector store may write
  // one register beyond that count.
  static constexpr size_t kSlack = 64;

  PairBuffer() = default;
  ~PairBuffer() { Release(); }
  // A move swaps the two buffers. So the moved-from buffer stays usable; it is empty if the target
  // was new.
  PairBuffer(PairBuffer&& other) noexcept { *this = std::move(other); }
  PairBuffer& operator=(PairBuffer&& other) noexcept {
    std::swap(storage_, other.storage_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::span<const OverlapPair> pairs() const { return {storage_, size_}; }
  std::span<OverlapPair> pairs() { return {storage_, size_}; }
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

  // Makes room for `count` more pairs plus kSlack. Returns the end of the array, where the caller
  // writes them before it calls Advance with their number. If memory runs out (OutOfMemory), the
  // content is unchanged.
  OverlapPair* EnsureRoom(size_t count) {
    if (size_ + count > capacity_ || storage_ == nullptr) Grow(size_ + count);
    return storage_ + size_;
  }
  void Advance(size_t count) { size_ += count; }

 private:
  void Grow(size_t needed) {
    size_t capacity = capacity_ < 512 ? 1024 : capacity_ * 2;
    if (capacity < needed) capacity = needed;
    void* const grown =
        AllocateMemory((capacity + kSlack) * sizeof(OverlapPair), alignof(OverlapPair));
    if (size_ > 0) std::memcpy(grown, storage_, size_ * sizeof(OverlapPair));
    Release();
    storage_ = static_cast<OverlapPair*>(grown);
    capacity_ = capacity;
  }

  void Release() { ReleaseMemory(storage_, capacity_bytes(), alignof(OverlapPair)); }

  OverlapPair* storage_ = nullptr;
  size_t size_ = 0;
  size_t capacity_ = 0;
};

}  // namespace sweepstake
