#include "engine_client/adaptive/invalid_box_counter.h"

#include <algorithm>

#include "engine_client/broad_phase/common/box_record.h"

namespace sweepstake {
namespace {

bool IsEmpty(const Aabb& box) {
  return box.min[0] > box.max[0] && box.min[1] > box.max[1] && box.min[2] > box.max[2];
}

uint32_t CountInvalid(std::span<const Aabb> boxes) {
  return static_cast<uint32_t>(std::count_if(boxes.begin(), boxes.end(), [](const Aabb& box) {
    return !IsValidFast(box) && !IsEmpty(box);
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
  if (boxes.size() < box_count_ && count_ > 0) return CountAll(boxes);
  if (boxes.size() > box_count_) count_ += CountInvalid(boxes.subspan(box_count_));
  box_count_ = boxes.size();
  next_ = std::min(next_, box_count_);
  pass_count_ = std::min(pass_count_, static_cast<uint32_t>(next_));
  const size_t share = (box_count_ + kFramesPerPass - 1) / kFramesPerPass;
  const size_t read_count = std::min(std::max(share, kMinBoxesPerFrame), box_count_ - next_);
  pass_count_ += CountInvalid(boxes.subspan(next_, read_count));
  next_ += read_count;
  count_ = std::clamp(count_, pass_count_, static_cast<uint32_t>(box_count_));
  if (next_ < box_count_) return;
  count_ = pass_count_;
  pass_count_ = 0;
  next_ = 0;
}

}  // namespace sweepstake
