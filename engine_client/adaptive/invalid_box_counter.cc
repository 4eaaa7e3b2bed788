#include "engine_client/adaptive/invalid_box_counter.h"

#include <algorithm>
#include <bit>

namespace sweepstake {
namespace {

// Returns false for an invalid box, and true for most valid ones. It takes half the time of
// IsValid.
bool IsSurelyValid(const Aabb& box) {
  constexpr uint32_t kInfinityBits = 0x7F80'0000;
  uint32_t largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Negative values, infinities and NaN have larger bits than any finite value from 0 on.
    largest = std::max(largest, std::bit_cast<uint32_t>(box.max[axis] - box.min[axis]));
  }
  return largest < kInfinityBits;
}

bool IsEmpty(const Aabb& box) {
  return box.min[0] > box.max[0] && box.min[1] > box.max[1] && box.min[2] > box.max[2];
}

uint32_t CountInvalid(std::span<const Aabb> boxes) {
  return static_cast<uint32_t>(std::count_if(boxes.begin(), boxes.end(), [](const Aabb& box) {
    return !IsSurelyValid(box) && !IsValid(box) && !IsEmpty(box);
  }));
}

}  // namespace

void InvalidBoxCounter::CountAll(std::span<const Aabb> boxes) {
  count_ = CountInvalid(boxes);
  pass_count_ = 0;
  next_ = 0;
  box_count_ = boxes.size();
}

void InvalidBoxCounter::Follow(std::span<const Aabb> boxes) {
  if (boxes.size() > box_count_) count_ += CountInvalid(boxes.subspan(box_count_));
  box_count_ = boxes.size();
  next_ = std::min(next_, box_count_);
  pass_count_ = std::min(pass_count_, static_cast<uint32_t>(next_));
  const size_t read_count = std::min(kBoxesPerFrame, box_count_ - next_);
  pass_count_ += CountInvalid(boxes.subspan(next_, read_count));
  next_ += read_count;
  count_ = std::clamp(count_, pass_count_, static_cast<uint32_t>(box_count_));
  if (next_ < box_count_) return;
  count_ = pass_count_;
  pass_count_ = 0;
  next_ = 0;
}

}  // namespace sweepstake
