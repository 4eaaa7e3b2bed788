// Writes the state of a ProxySet to bytes and restores it.
//
// A class lists its fields once, in a function `Visit(self, archive)` for the three archives below:
// archive.Value(field) for plain values, archive.Array(list) for lists of plain values. The bytes
// are those in memory, without padding between fields, for machines of the same byte order.
//
// Not thread-safe. Borrows the bytes. Errors: SnapshotReader::failed().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class SnapshotSizer {
 public:
  template <typename T>
  void Value(const T& value) {
    bytes_ += sizeof value;
  }
  template <typename List>
  void Array(const List& list) {
    bytes_ += sizeof(uint64_t) + list.size() * sizeof(*list.data());
  }
  size_t bytes() const { return bytes_; }

 private:
  size_t bytes_ = 0;
};

class SnapshotWriter {
 public:
  // REQUIRES: `at` has room for everything that is written.
  explicit SnapshotWriter(std::byte* at) : at_(at) {}

  template <typename T>
  void Value(const T& value) {
    Copy(&value, sizeof value);
  }
  template <typename List>
  void Array(const List& list) {
    Value(uint64_t{list.size()});
    Copy(list.data(), list.size() * sizeof(*list.data()));
  }

 private:
  void Copy(const void* from, size_t bytes) {
    if (bytes > 0) std::memcpy(at_, from, bytes);
    at_ += bytes;
  }

  std::byte* at_;
};

class SnapshotReader {
 public:
  explicit SnapshotReader(std::span<const std::byte> bytes) : left_(bytes) {}

  template <typename T>
  void Value(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (left_.size() < sizeof value) return Fail();
    Copy(&value, sizeof value);
  }
  template <typename List>
  void Array(List& list) {
    uint64_t count = 0;
    Value(count);
    if (count > left_.size() / sizeof(*list.data())) return Fail();
    list.resize(count);
    Copy(list.data(), count * sizeof(*list.data()));
  }
  // Returns whether the bytes ended early. The values read must then not be used.
  bool failed() const { return failed_; }
  bool at_end() const { return left_.empty(); }

 private:
  void Fail() {
    failed_ = true;
    left_ = {};
  }
  void Copy(void* to, size_t bytes) {
    if (bytes > 0) std::memcpy(to, left_.data(), bytes);
    left_ = left_.subspan(bytes);
  }

  std::span<const std::byte> left_;
  bool failed_ = false;
};

// Gives a PairBuffer the interface of the lists that archives accept.
template <typename Buffer>
class PairList {
 public:
  explicit PairList(Buffer& buffer) : buffer_(buffer) {}
  size_t size() const { return buffer_.size(); }
  auto* data() const { return buffer_.pairs().data(); }
  void resize(size_t count) const {
    buffer_.Clear();
    buffer_.EnsureRoom(count);
    buffer_.Advance(count);
  }

 private:
  Buffer& buffer_;
};

// Returns a checksum that changes almost certainly if any bit changes. It detects damage, not
// deliberate changes.
inline uint64_t Checksum(std::span<const std::byte> bytes) {
  constexpr uint64_t kOdd = 0x9e3779b97f4a7c15U;
  // Four sums run in parallel, since within a sum each multiplication waits for the previous one.
  std::array<uint64_t, 4> sums{1, 2, 3, 4};
  const auto add = [&](uint64_t& sum, const std::byte* at, size_t count) {
    uint64_t word = 0;
    std::memcpy(&word, at, count);
    sum = (sum ^ word) * kOdd;
    sum ^= sum >> 29;
  };
  const std::byte* at = bytes.data();
  size_t left = bytes.size();
  for (; left >= 32; left -= 32, at += 32) {
    for (size_t k = 0; k < 4; ++k) add(sums[k], at + 8 * k, 8);
  }
  for (; left > 0; at += left < 8 ? left : 8, left -= left < 8 ? left : 8) {
    add(sums[0], at, left < 8 ? left : 8);
  }
  uint64_t all = bytes.size();
  for (const uint64_t sum : sums) all = (all ^ sum) * kOdd;
  return all ^ all >> 32;
}

}  // namespace sweepstake
