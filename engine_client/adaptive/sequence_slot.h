// Passes values from one thread to others without making either wait: sequence locks made of
// atomics.
//
// A slot's version is 2i + 1 while the writer writes value i, and 2i + 2 once the value is
// complete. A reader therefore discards what it read from a slot that was overwritten meanwhile.
// Words are stored with release and loaded with acquire, which costs nothing on x86. A reader that
// sees a word of a later value then also sees the changed version. Fences would work too, but
// ThreadSanitizer does not support them.
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
  // Writes value number `index`. Numbers count up from 0.
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
  // NOLINTNEXTLINE(bugprone-sizeof-expression): taken for a count of an array's elements.
  static constexpr size_t kWordCount = sizeof(T) / sizeof(uint64_t);
  using Words = std::array<uint64_t, kWordCount>;

  std::atomic<uint64_t> version_{0};
  std::array<std::atomic<uint64_t>, kWordCount> words_{};
};

// The latest value of a writer. A reader retries only if two values were written while it read. The
// two slots alternate, so a writer that is suspended while it writes does not block readers.
template <typename T>
class LatestSlot {
 public:
  void Set(const T& value) noexcept {
    const uint64_t index = count_.load(std::memory_order_relaxed);
    slots_[index % 2].Write(index, value);
    count_.store(index + 1, std::memory_order_release);
  }

  // Absent before the first Set.
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
