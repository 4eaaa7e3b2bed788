// A bounded queue from one producer thread to one consumer thread that never makes the producer
// wait: when it is full, it overwrites the oldest element, and the consumer learns the number of
// lost elements.
//
// Each slot is a sequence lock made of atomics. Its version is 2i + 1 while the producer writes
// element i, and 2i + 2 once the element is complete, so that the consumer discards what it read
// from a slot that was overwritten meanwhile. Words are stored with release and loaded with
// acquire, which costs nothing on x86: a consumer that sees a word of element i + capacity then
// also sees the slot's version change. (Fences would do too, but ThreadSanitizer does not
// understand them.)
//
// Thread safety: Push on the producer, Pop on the consumer, the counts on any thread. Memory:
// allocated once. Cost: Push is one pass over the words, without a read-modify-write, a system
// call, or an allocation.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>

namespace sweepstake {

template <typename T>
// The padding keeps the two threads' cache lines apart.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class LossyRing {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(uint64_t) == 0);

 public:
  // REQUIRES: capacity is a power of two, at least 2.
  explicit LossyRing(uint32_t capacity)
      : mask_(uint64_t{capacity} - 1), slots_(std::make_unique<Slot[]>(capacity)) {
    assert(capacity >= 2 && std::has_single_bit(capacity));
  }

  void Push(const T& element) noexcept {
    const uint64_t index = head_.load(std::memory_order_relaxed);
    const Words words = std::bit_cast<Words>(element);
    Slot& slot = slots_[index & mask_];
    slot.version.store(2 * index + 1, std::memory_order_relaxed);
    for (size_t i = 0; i < kWordCount; ++i) {
      slot.words[i].store(words[i], std::memory_order_release);
    }
    slot.version.store(2 * index + 2, std::memory_order_release);
    head_.store(index + 1, std::memory_order_release);
  }

  // Takes the oldest element that is still there. Elements come in order, each at most once.
  std::optional<T> Pop() noexcept {
    for (;;) {
      const uint64_t index = passed_count();
      const uint64_t head = pushed_count();
      if (index == head) return std::nullopt;
      if (head - index <= capacity()) {
        if (const std::optional<T> element = Read(index)) {
          tail_.store(index + 1, std::memory_order_relaxed);
          return element;
        }
      }
      SkipOverwritten(index);
    }
  }

  uint64_t capacity() const { return mask_ + 1; }
  // Returns the number of elements pushed since the beginning.
  uint64_t pushed_count() const noexcept { return head_.load(std::memory_order_acquire); }
  // Returns the number of elements popped or lost since the beginning, which is the index of the
  // next one.
  uint64_t passed_count() const noexcept { return tail_.load(std::memory_order_relaxed); }
  // Returns the number of elements that were overwritten before they were popped, including those
  // that the consumer has not skipped yet.
  uint64_t lost_count() const noexcept {
    const uint64_t tail = passed_count();
    const uint64_t head = pushed_count();
    const uint64_t overdue = head > tail + capacity() ? head - tail - capacity() : 0;
    return lost_.load(std::memory_order_relaxed) + overdue;
  }

 private:
  // NOLINTNEXTLINE(bugprone-sizeof-expression): taken for a count of an array's elements.
  static constexpr size_t kWordCount = sizeof(T) / sizeof(uint64_t);
  using Words = std::array<uint64_t, kWordCount>;

  struct Slot {
    std::atomic<uint64_t> version{0};
    std::array<std::atomic<uint64_t>, kWordCount> words{};
  };

  std::optional<T> Read(uint64_t index) const noexcept {
    const Slot& slot = slots_[index & mask_];
    const uint64_t whole = 2 * index + 2;
    if (slot.version.load(std::memory_order_acquire) != whole) return std::nullopt;
    Words words;
    for (size_t i = 0; i < kWordCount; ++i) {
      words[i] = slot.words[i].load(std::memory_order_acquire);
    }
    if (slot.version.load(std::memory_order_relaxed) != whole) return std::nullopt;
    return std::bit_cast<T>(words);
  }

  // Moves on to the oldest element that is not overwritten yet. The one at `index` is lost.
  void SkipOverwritten(uint64_t index) noexcept {
    const uint64_t head = pushed_count();
    const uint64_t oldest = head > capacity() ? head - capacity() : 0;
    const uint64_t next = std::max(index + 1, oldest);
    lost_.store(lost_.load(std::memory_order_relaxed) + (next - index), std::memory_order_relaxed);
    tail_.store(next, std::memory_order_relaxed);
  }

  const uint64_t mask_;
  const std::unique_ptr<Slot[]> slots_;
  // On separate cache lines, so that the consumer's writes do not slow the producer down.
  alignas(64) std::atomic<uint64_t> head_{0};
  alignas(64) std::atomic<uint64_t> tail_{0};
  std::atomic<uint64_t> lost_{0};
};

}  // namespace sweepstake
