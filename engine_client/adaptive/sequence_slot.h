// Passes values from one thread to others. Neither the writer nor a reader waits. The slots are
// sequence locks made of atomics.
//
// A slot's version is 2i + 1 while the writer writes value i, and 2i + 2 when value i is complete.
// A reader compares the version before and after reading. If it changed, the slot was overwritten
// in between, and the reader discards what it read.
//
// Words are stored with release and loaded with acquire order, which costs nothing on x86. A reader
// that sees a word of a later value therefore also sees the changed version. Fences would work too,
// but ThreadSanitizer does not support them.
//
// Thread safety: one writer at a time, any number of readers. No allocation and no system call.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>

namespace sweepstake {

template <typename T>
class SequenceSlot {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(uint64_t) == 0);

 public:
  // Writes value number `index`. The first value has the number 0, and each one the next number.
  void Write(uint64_t index, const T& value) noexcept {
    Words words;
    std::memcpy(words.data(), &value, sizeof value);
    version_.store(2 * index + 1, std::memory_order_relaxed);
    for (size_t i = 0; i < kWordCount; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(2 * index + 2, std::memory_order_release);
  }

  // Returns value number `index`, unless the slot holds another one or is being written.
  std::optional<T> Read(uint64_t index) const noexcept {
    const uint64_t whole = 2 * index + 2;
    if (version_.load(std::memory_order_acquire) != whole) return std::nullopt;
    Words words;
    for (size_t i = 0; i < kWordCount; ++i) words[i] = words_[i].load(std::memory_order_acquire);
    if (version_.load(std::memory_order_relaxed) != whole) return std::nullopt;
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof value);
    return value;
  }

 private:
  // NOLINTNEXTLINE(bugprone-sizeof-expression): the check takes it for a count of array elements.
  static constexpr size_t kWordCount = sizeof(T) / sizeof(uint64_t);
  using Words = std::array<uint64_t, kWordCount>;

  std::atomic<uint64_t> version_{0};
  std::array<std::atomic<uint64_t>, kWordCount> words_{};
};

// Holds the latest value of a writer. A reader retries only if two values were written while it was
// reading. Writes alternate between two slots, so a writer that is suspended in the middle of a
// write does not block readers.
template <typename T>
class LatestSlot {
 public:
  void Set(const T& value) noexcept {
    const uint64_t index = count_.load(std::memory_order_relaxed);
    slots_[index % 2].Write(index, value);
    count_.store(index + 1, std::memory_order_release);
  }

  // Returns the latest value; absent before the first Set.
  std::optional<T> Get() const noexcept {
    for (;;) {
      const uint64_t count = count_.load(std::memory_order_acquire);
      if (count == 0) return std::nullopt;
      if (const std::optional<T> value = slots_[(count - 1) % 2].Read(count - 1)) return value;
    }
  }

 private:
  std::array<SequenceSlot<T>, 2> slots_;
  std::atomic<uint64_t> count_{0};
};

}  // namespace sweepstake
