#include "engine_client/adaptive/box_tap.h"

#include <algorithm>
#include <cassert>

namespace sweepstake {
namespace {

constexpr uint32_t Pack(uint32_t requested, uint32_t filled) { return requested << 8 | filled; }
constexpr uint32_t Requested(uint32_t word) { return word >> 8; }
constexpr uint32_t Filled(uint32_t word) { return word & 0xFF; }

}  // namespace

void BoxTap::OnFrame(std::span<const Aabb> boxes, const FrameNote& note, Clock& clock) noexcept {
  latest_frame_.store(note.frame_index, std::memory_order_relaxed);
  const uint32_t word = word_.load(std::memory_order_acquire);
  const uint32_t filled = Filled(word);
  if (Requested(word) == filled) return;
  if (boxes.size() > capacity_) {
    too_big_count_ = boxes.size();
    word_.store(Pack(filled, filled), std::memory_order_release);
    return;
  }
  const uint64_t start_ns = clock.NowNs();
  std::copy(boxes.begin(), boxes.end(),
            storage_.begin() + static_cast<std::ptrdiff_t>(filled * capacity_));
  slots_[filled] = {
      .note = note, .object_count = boxes.size(), .copy_time_ns = clock.NowNs() - start_ns};
  word_.store(word + 1, std::memory_order_release);
}

void BoxTap::Reserve(uint32_t slot_count, size_t object_count) {
  assert(complete() && slot_count <= kMaxSlots);
  word_.store(0, std::memory_order_relaxed);
  slot_count_ = 0;
  capacity_ = 0;
  HookedVector<Aabb>().swap(storage_);
  // resize writes to the memory, so the frame thread will not cause page faults.
  storage_.resize(slot_count * object_count);
  slot_count_ = slot_count;
  capacity_ = object_count;
}

void BoxTap::Request(uint32_t frame_count) {
  assert(complete() && frame_count >= 1 && frame_count <= slot_count_);
  too_big_count_ = 0;
  word_.store(Pack(frame_count, 0), std::memory_order_release);
}

uint32_t BoxTap::filled_count() const { return Filled(word_.load(std::memory_order_acquire)); }

bool BoxTap::complete() const {
  const uint32_t word = word_.load(std::memory_order_acquire);
  return Requested(word) == Filled(word);
}

uint64_t BoxTap::frame_time_ns() const {
  constexpr uint64_t kMaxFrameNs = 1'000'000'000;
  uint64_t sum_ns = 0;
  for (uint32_t slot = 0; slot < filled_count(); ++slot)
    sum_ns += std::min(frame(slot).note.frame_time_ns, kMaxFrameNs);
  return sum_ns;
}

TappedFrame BoxTap::frame(uint32_t slot) const {
  const Slot& taken = slots_[slot];
  return {.note = taken.note,
          .boxes = std::span(storage_).subspan(slot * capacity_, taken.object_count),
          .copy_time_ns = taken.copy_time_ns};
}

}  // namespace sweepstake
