// A bounded queue from one producer thread to one consumer thread that never makes the producer
// wait. A full queue overwrites its oldest element and counts the lost elements.
//
// Each slot is a sequence lock (sequence_slot.h): the consumer detects a slot that was overwritten
// while it was read, and discards the value.
//
// Thread safety: Push on the producer, Pop on the consumer, the counts on any thread. Memory:
// allocated once. Cost: Push is one pass over the words, without a read-modify-write, a system
// call, or an allocation.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>

#include "engine_client/adaptive/sequence_slot.h"

namespace sweepstake {

template <typename T>
// Padding separates the members of the two threads, so that they are on different cache lines.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class LossyRing {
 public:
  // REQUIRES: capacity is a power of two, at least 2.
  explicit LossyRing(uint32_t capacity)
      : mask_(uint64_t{capacity} - 1), slots_(std::make_unique<SequenceSlot<T>[]>(capacity)) {
    assert(capacity >= 2 && std::has_single_bit(capacity));
  }

  void Push(const T& element) noexcept {
    const uint64_t index = head_.load(std::memory_order_relaxed);
    slots_[index & mask_].Write(index, element);
    head_.store(index + 1, std::memory_order_release);
  }

  // Removes and returns the oldest element that still exists. Elements come in order, each at most
  // once.
  std::optional<T> Pop() noexcept {
    for (;;) {
      const uint64_t index = passed_count();
      const uint64_t head = pushed_count();
      if (index == head) return std::nullopt;
      if (head - index <= capacity()) {
        if (const std::optional<T> element = slots_[index & mask_].Read(index)) {
          tail_.store(index + 1, std::memory_order_relaxed);
          return element;
        }
      }
      SkipOverwritten(index);
    }
  }

  uint64_t capacity() const { return mask_ + 1; }
  // Returns the number of elements pushed so far.
  uint64_t pushed_count() const noexcept { return head_.load(std::memory_order_acquire); }
  // Returns the number of elements popped or lost so far, which is also the index of the next
  // element to pop.
  uint64_t passed_count() const noexcept { return tail_.load(std::memory_order_relaxed); }
  // Returns the number of elements that were overwritten before they were popped. It includes the
  // elements that the next Pop will skip.
  uint64_t lost_count() const noexcept {
    const uint64_t tail = passed_count();
    const uint64_t head = pushed_count();
    const uint64_t overdue = head > tail + capacity() ? head - tail - capacity() : 0;
    return lost_.load(std::memory_order_relaxed) + overdue;
  }

 private:
  // Skips the element at `index` and all others that were overwritten, and counts them as lost.
  void SkipOverwritten(uint64_t index) noexcept {
    const uint64_t head = pushed_count();
    const uint64_t oldest = head > capacity() ? head - capacity() : 0;
    const uint64_t next = std::max(index + 1, oldest);
    lost_.store(lost_.load(std::memory_order_relaxed) + (next - index), std::memory_order_relaxed);
    tail_.store(next, std::memory_order_relaxed);
  }

  const uint64_t mask_;
  const std::unique_ptr<SequenceSlot<T>[]> slots_;
  // head_ and tail_ are on separate cache lines, so that the consumer does not slow the producer.
  alignas(64) std::atomic<uint64_t> head_{0};
  alignas(64) std::atomic<uint64_t> tail_{0};
  std::atomic<uint64_t> lost_{0};
};

}  // namespace sweepstake
