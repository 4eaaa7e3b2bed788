#include "engine_client/broad_phase/pair_set.h"

#include <algorithm>
#include <bit>

namespace sweepstake {
namespace {

constexpr uint32_t kEmpty = 0xFFFFFFFF;
constexpr size_t kFewestSlots = 64;

}  // namespace

void PairSet::Clear() {
  size_ = 0;
  std::fill_n(slots_.data(), slot_count_, kEmpty);
}

void PairSet::Reserve(size_t count) {
  pairs_.EnsureKeeping(count, size_);
  const size_t needed = std::bit_ceil(std::max(2 * count, kFewestSlots));
  if (needed > slot_count_) Rebuild(needed);
}

bool PairSet::Insert(OverlapPair pair) {
  if (2 * (size_ + 1) > slot_count_ || size_ == pairs_.capacity())
    Reserve(std::max<size_t>(2 * size_, 32));
  const size_t slot = SlotOf(pair);
  if (slots_[slot] != kEmpty) return false;
  slots_[slot] = static_cast<uint32_t>(size_);
  pairs_[size_++] = pair;
  return true;
}

// The last pair takes the place of the erased one.
bool PairSet::Erase(OverlapPair pair) {
  if (size_ == 0) return false;
  const size_t slot = SlotOf(pair);
  const uint32_t index = slots_[slot];
  if (index == kEmpty) return false;
  const OverlapPair last = pairs_[size_ - 1];
  slots_[SlotOf(last)] = index;
  pairs_[index] = last;
  --size_;
  CloseGap(slot);
  return true;
}

// Fibonacci hashing: the high bits of the product are well mixed.
size_t PairSet::Home(OverlapPair pair) const {
  const uint64_t key = uint64_t{pair.a} << 32 | pair.b;
  return static_cast<size_t>((key * 0x9E3779B97F4A7C15U) >> 32) & (slot_count_ - 1);
}

// Where the pair is, or the empty slot where it would go.
size_t PairSet::SlotOf(OverlapPair pair) const {
  size_t slot = Home(pair);
  while (slots_[slot] != kEmpty && pairs_[slots_[slot]] != pair)
    slot = (slot + 1) & (slot_count_ - 1);
  return slot;
}

// Moves later pairs of the same run forward, so that no probe ends early: no tombstones to clean
// up.
void PairSet::CloseGap(size_t gap) {
  const size_t mask = slot_count_ - 1;
  for (size_t slot = (gap + 1) & mask; slots_[slot] != kEmpty; slot = (slot + 1) & mask) {
    const size_t home = Home(pairs_[slots_[slot]]);
    if (((slot - home) & mask) < ((slot - gap) & mask)) continue;
    slots_[gap] = slots_[slot];
    gap = slot;
  }
  slots_[gap] = kEmpty;
}

void PairSet::Rebuild(size_t slot_count) {
  slots_.EnsureDiscarding(slot_count);
  slot_count_ = slot_count;
  std::fill_n(slots_.data(), slot_count_, kEmpty);
  for (size_t i = 0; i < size_; ++i) slots_[SlotOf(pairs_[i])] = static_cast<uint32_t>(i);
}

}  // namespace sweepstake
