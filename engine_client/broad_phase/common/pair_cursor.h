// Writes a kernel's pairs to a PairBuffer. It reserves room in chunks, so that checking for room
// costs one comparison in the inner loop.
//
// Not thread-safe. Borrows the buffer; Flush makes the written pairs part of its content. Vector
// stores may overrun the reserved room by PairBuffer::kSlack pairs.
#pragma once

#include <algorithm>
#include <cstddef>

#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class PairCursor {
 public:
  explicit PairCursor(PairBuffer& out) : out_(out), at_(out.EnsureRoom(kChunk)) {}
  PairCursor(const PairCursor&) = delete;
  PairCursor& operator=(const PairCursor&) = delete;

  // Returns where to write the next `count` pairs. Throws std::bad_alloc.
  OverlapPair* Room(size_t count) {
    if (used_ + count > room_) Claim(count);
    return at_ + used_;
  }
  void Advance(size_t count) { used_ += count; }
  void Append(uint32_t first, uint32_t second) {
    *Room(1) = {std::min(first, second), std::max(first, second)};
    Advance(1);
  }

  void Flush() {
    out_.Advance(used_);
    at_ += used_;
    room_ -= used_;
    used_ = 0;
  }

 private:
  // The chunk equals the first capacity of a PairBuffer, so that a small scene reserves room once.
  static constexpr size_t kChunk = 1024;

  void Claim(size_t count) {
    Flush();
    room_ = std::max(count, kChunk);
    at_ = out_.EnsureRoom(room_);
  }

  PairBuffer& out_;
  OverlapPair* at_;
  size_t used_ = 0;
  size_t room_ = kChunk;
};

}  // namespace sweepstake
