#include "engine_client/broad_phase/kd/kd_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/kd_split.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kWidth = KdRange::kPart;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// The size of the sample from which the median is estimated if there are more keys. Keys are the
// centers' coordinates on the split axis.
constexpr size_t kSampleSize = 256;
// The distance of the bracket's two ranks from the wanted rank in the sample: two standard
// deviations of the median's rank.
constexpr size_t kSampleMargin = 16;

// Two values and the number of keys below each. The requested rank is between these numbers.
struct Bracket {
  float low = -kInfinity;
  float high = kInfinity;
  size_t below_low = 0;
  size_t below_high = 0;
};

// Takes 16 keys of the sample as candidates, or 32 if the sample has 17 to 32 keys. Finds the
// largest candidate with at most `low_rank` keys below it, and the smallest with at least
// `high_rank`.
Bracket BracketInSample(const float* sample, size_t count, size_t low_rank, size_t high_rank) {
  // Takes evenly spaced keys of the sample as candidates.
  const Lanes16 d;
  alignas(64) float candidates[2 * kWidth];
  const size_t candidate_count = count > kWidth && count <= 2 * kWidth ? 2 * kWidth : kWidth;
  for (size_t k = 0; k < candidate_count; ++k) {
    candidates[k] = sample[(2 * k + 1) * count / (2 * candidate_count)];
  }
  // Starts with infinite bounds in every lane.
  const auto one = hn::Set(d, 1.0F);
  const auto max_below_low = hn::Set(d, static_cast<float>(low_rank));
  const auto min_below_high = hn::Set(d, static_cast<float>(high_rank));
  auto low = hn::Set(d, -kInfinity);
  auto high = hn::Set(d, kInfinity);
  auto below_low = hn::Zero(d);
  auto below_high = hn::Set(d, static_cast<float>(count));
  for (size_t at = 0; at < candidate_count; at += hn::Lanes(d)) {
    const auto candidate = hn::Load(d, candidates + at);
    // Counts how many keys are below each candidate. Two independent sums run in parallel.
    auto even = hn::Zero(d);
    auto odd = hn::Zero(d);
    size_t k = 0;
    for (; k + 2 <= count; k += 2) {
      even = hn::Add(even, hn::IfThenElseZero(hn::Gt(candidate, hn::Set(d, sample[k])), one));
      odd = hn::Add(odd, hn::IfThenElseZero(hn::Gt(candidate, hn::Set(d, sample[k + 1])), one));
    }
    if (k < count) {
      odd = hn::Add(odd, hn::IfThenElseZero(hn::Gt(candidate, hn::Set(d, sample[k])), one));
    }
    // Sets `low` to the largest and `high` to the smallest suitable candidate of each lane so far.
    const auto rank = hn::Add(even, odd);
    const auto is_low = hn::Le(rank, max_below_low);
    const auto is_high = hn::Ge(rank, min_below_high);
    low = hn::IfThenElse(is_low, hn::Max(low, candidate), low);
    below_low = hn::IfThenElse(is_low, hn::Max(below_low, rank), below_low);
    high = hn::IfThenElse(is_high, hn::Min(high, candidate), high);
    below_high = hn::IfThenElse(is_high, hn::Min(below_high, rank), below_high);
  }
  // Reduces the lanes to the tightest bracket.
  return {hn::GetLane(hn::MaxOfLanes(d, low)), hn::GetLane(hn::MinOfLanes(d, high)),
          static_cast<size_t>(hn::GetLane(hn::MaxOfLanes(d, below_low))),
          static_cast<size_t>(hn::GetLane(hn::MinOfLanes(d, below_high)))};
}

size_t CountBelow(const float* keys, size_t count, float limit) {
  const Lanes16 d;
  const auto bound = hn::Set(d, limit);
  size_t below = 0;
  for (size_t at = 0; at < count; at += hn::Lanes(d)) {
    const auto inside = hn::FirstN(d, count - at);
    below += hn::CountTrue(d, hn::And(inside, hn::Lt(hn::LoadU(d, keys + at), bound)));
  }
  return below;
}

// Finds a bracket in the sample that is likely to hold the rank `left`, and counts the keys below
// it. If the count shows that a bound is on the wrong side of the rank, that bound becomes
// infinite.
Bracket BracketOfMany(const float* keys, size_t count, size_t left) {
  alignas(64) float sample[kSampleSize];
  for (size_t k = 0; k < kSampleSize; ++k) sample[k] = keys[k * count / kSampleSize];
  const size_t rank = left * kSampleSize / count;
  Bracket bracket = BracketInSample(sample, kSampleSize, rank - std::min(rank, kSampleMargin),
                                    rank + kSampleMargin);
  bracket.below_low = CountBelow(keys, count, bracket.low);
  bracket.below_high = CountBelow(keys, count, bracket.high);
  if (bracket.below_low > left) {
    bracket.low = -kInfinity;
    bracket.below_low = 0;
  }
  if (bracket.below_high < left) {
    bracket.high = kInfinity;
    bracket.below_high = count;
  }
  return bracket;
}

// Returns a bracket with one bound just above the first key. It is used if so many keys are equal
// that no other bracket was found.
Bracket BracketOfMinimum(const float* keys, size_t count, size_t left) {
  Bracket bracket;
  bracket.below_high = count;
  const float above = std::nextafter(keys[0], kInfinity);
  const size_t below = CountBelow(keys, count, above);
  // `below` is 0 only if comparisons treat denormals as 0. All keys then count as equal.
  if (below == 0) return bracket;
  if (below <= left) {
    bracket.low = above;
    bracket.below_low = below;
  } else {
    bracket.high = above;
    bracket.below_high = below;
  }
  return bracket;
}

// Finds a bracket with fewer than `count` keys between its values. If all keys are equal, the
// bracket contains all of them.
Bracket FindBracket(const float* keys, size_t count, size_t left) {
  const Bracket bracket = count <= kSampleSize ? BracketInSample(keys, count, left, left)
                                               : BracketOfMany(keys, count, left);
  if (bracket.below_high - bracket.below_low < count) return bracket;
  return BracketOfMinimum(keys, count, left);
}

template <class D, class V, class T>
HWY_INLINE void StoreFirst(D d, V values, size_t count, T* to, bool whole) {
  if (HWY_LIKELY(whole)) {
    hn::StoreU(values, d, to);
    return;
  }
  alignas(64) T buffer[kWidth];
  hn::Store(values, d, buffer);
  std::copy(buffer, buffer + count, to);
}

// Copies the chosen slots of the register at `source` to `to`, from `target` on. Returns their
// number. Stores whole registers unless they would pass `limit`.
template <class D>
HWY_INLINE size_t AppendChosen(D d, hn::Mask<D> chosen, const KdColumns& from, size_t source,
                               const KdColumns& to, size_t target, size_t limit) {
  const hn::RebindToUnsigned<D> du;
  const size_t count = hn::CountTrue(d, chosen);
  const bool whole = target + hn::Lanes(d) <= limit;
  const auto center0 = hn::LoadU(d, from.center[0] + source);
  const auto center1 = hn::LoadU(d, from.center[1] + source);
  const auto center2 = hn::LoadU(d, from.center[2] + source);
  const auto box = hn::LoadU(du, from.box + source);
  StoreFirst(d, CompressLanes(center0, chosen), count, to.center[0] + target, whole);
  StoreFirst(d, CompressLanes(center1, chosen), count, to.center[1] + target, whole);
  StoreFirst(d, CompressLanes(center2, chosen), count, to.center[2] + target, whole);
  StoreFirst(du, CompressLanes(box, hn::RebindMask(du, chosen)), count, to.box + target, whole);
  return count;
}

// Distributes `count` slots of `from`, from `source` on, by their keys. Keys below the bracket go
// to `to` from `target` on. Keys above it also go to `to`, behind a gap for the keys in between,
// which move to the front in `from`. This takes two passes: storing whole registers overwrites some
// slots behind the keys below, so that the keys above must be written later.
void Scatter(const KdColumns& from, const KdColumns& to, size_t source, size_t count, size_t target,
             size_t axis, const Bracket& bracket, size_t limit) {
  const Lanes16 d;
  const auto low = hn::Set(d, bracket.low);
  const auto high = hn::Set(d, bracket.high);
  const size_t end = source + count;
  // First pass: copies the slots below the bracket.
  size_t below = target;
  for (size_t at = source; at < end; at += hn::Lanes(d)) {
    const auto is_below =
        hn::And(hn::FirstN(d, end - at), hn::Lt(hn::LoadU(d, from.center[axis] + at), low));
    below += AppendChosen(d, is_below, from, at, to, below, limit);
  }
  // Second pass: copies the slots above the bracket, and moves the slots in between to the front.
  size_t above = target + bracket.below_high;
  size_t between = source;
  for (size_t at = source; at < end; at += hn::Lanes(d)) {
    const auto inside = hn::FirstN(d, end - at);
    const auto key = hn::LoadU(d, from.center[axis] + at);
    const auto is_above = hn::And(inside, hn::Ge(key, high));
    const auto is_between = hn::AndNot(hn::Or(is_above, hn::Lt(key, low)), inside);
    above += AppendChosen(d, is_above, from, at, to, above, limit);
    if (hn::AllFalse(d, is_between)) continue;
    between += AppendChosen(d, is_between, from, at, from, between, limit);
  }
}

void Copy(const KdColumns& from, const KdColumns& to, size_t source, size_t count, size_t target) {
  for (size_t axis = 0; axis < 3; ++axis) {
    std::copy_n(from.center[axis] + source, count, to.center[axis] + target);
  }
  std::copy_n(from.box + source, count, to.box + target);
}

// Returns half the spread of the centers on one axis. The spread itself may overflow.
HWY_INLINE float HalfSpread(const float* centers, size_t count) {
  const Lanes16 d;
  auto min = hn::Set(d, centers[0]);
  auto max = min;
  size_t at = 0;
  for (; at + hn::Lanes(d) <= count; at += hn::Lanes(d)) {
    const auto center = hn::LoadU(d, centers + at);
    min = hn::Min(min, center);
    max = hn::Max(max, center);
  }
  if (at < count) {
    const auto inside = hn::FirstN(d, count - at);
    const auto center = hn::LoadU(d, centers + at);
    min = hn::IfThenElse(inside, hn::Min(min, center), min);
    max = hn::IfThenElse(inside, hn::Max(max, center), max);
  }
  return hn::GetLane(hn::MaxOfLanes(d, max)) * 0.5F - hn::GetLane(hn::MinOfLanes(d, min)) * 0.5F;
}

size_t WidestAxis(const KdColumns& columns, const KdRange& range) {
  size_t widest = 0;
  float extent = -1;
  for (size_t axis = 0; axis < 3; ++axis) {
    const float other =
        HalfSpread(columns.center[axis] + range.begin, range.count()) * range.axis_weight[axis];
    if (!(other > extent)) continue;
    widest = axis;
    extent = other;
  }
  return widest;
}

// Saves a register of slots, to restore them later.
class SavedSlots {
 public:
  SavedSlots(const KdColumns& columns, size_t at) : columns_(columns), at_(at) {
    CopySlots(columns_, at_, {{centers_[0], centers_[1], centers_[2]}, boxes_}, 0);
  }
  void PutBack() { CopySlots({{centers_[0], centers_[1], centers_[2]}, boxes_}, 0, columns_, at_); }

 private:
  static void CopySlots(const KdColumns& from, size_t source, const KdColumns& to, size_t target) {
    const Lanes16 d;
    const hn::RebindToUnsigned<Lanes16> du;
    for (size_t lane = 0; lane < kWidth; lane += hn::Lanes(d)) {
      for (size_t axis = 0; axis < 3; ++axis) {
        hn::StoreU(hn::LoadU(d, from.center[axis] + source + lane), d,
                   to.center[axis] + target + lane);
      }
      hn::StoreU(hn::LoadU(du, from.box + source + lane), du, to.box + target + lane);
    }
  }

  const KdColumns columns_;
  const size_t at_;
  alignas(64) float centers_[3][kWidth];
  alignas(64) uint32_t boxes_[kWidth];
};

// Does the same as Scatter, but preserves the slots of `to` from target + count on, which are in
// use.
void ScatterAmong(const KdColumns& from, const KdColumns& to, size_t source, size_t count,
                  size_t target, size_t axis, const Bracket& bracket, size_t limit) {
  const size_t end = target + count;
  if (end + kWidth > limit) {
    return Scatter(from, to, source, count, target, axis, bracket, end);
  }
  SavedSlots behind(to, end);
  Scatter(from, to, source, count, target, axis, bracket, limit);
  behind.PutBack();
}

// Splits one range. Writes no slot from `limit` on, but may overwrite slots between the range's end
// and `limit`.
void SplitRange(const KdColumns& from, const KdColumns& to, const KdRange& range, size_t limit) {
  const size_t axis = WidestAxis(from, range);
  const float* const keys = from.center[axis] + range.begin;
  size_t count = range.count();
  size_t target = range.begin;
  size_t left = KdSplitPoint(range) - range.begin;
  while (left != 0 && left != count) {
    const Bracket bracket = FindBracket(keys, count, left);
    const size_t between = bracket.below_high - bracket.below_low;
    if (between == count) break;  // all keys are equal
    if (count == range.count()) {
      Scatter(from, to, range.begin, count, target, axis, bracket, limit);
    } else {
      ScatterAmong(from, to, range.begin, count, target, axis, bracket, limit);
    }
    target += bracket.below_low;
    left -= bracket.below_low;
    count = between;
  }
  Copy(from, to, range.begin, count, target);
}

// Splits a range recursively, its second part first. The first part may then overwrite slots behind
// it, since the boxes of the second part are already in `order`.
void SplitDown(const KdColumns& from, const KdColumns& to, const KdRange& range, size_t limit,
               uint32_t* order) {
  if (range.count() <= kWidth) {
    std::copy_n(from.box + range.begin, range.count(), order + range.begin);
    return;
  }
  SplitRange(from, to, range, limit);
  KdRange first = range;
  KdRange second = range;
  first.end = second.begin = KdSplitPoint(range);
  SplitDown(to, from, second, limit, order);
  SplitDown(to, from, first, limit, order);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(SplitRange);
HWY_EXPORT(SplitDown);

size_t KdSplitPoint(const KdRange& range) {
  const size_t count = range.count();
  size_t block = KdRange::kPart;
  for (size_t width = range.run_parts; block * width < count; width = 16) block *= width;
  const size_t nearest = (count / 2 + block / 2) / block * block;
  return range.begin + std::clamp(nearest, block, (count - 1) / block * block);
}

void SplitOnce(const KdColumns& from, const KdColumns& to, const KdRange& range) {
  HWY_DYNAMIC_DISPATCH(SplitRange)(from, to, range, range.end);
}

void SplitAll(const KdColumns& from, const KdColumns& to, const KdRange& range, uint32_t* order) {
  HWY_DYNAMIC_DISPATCH(SplitDown)(from, to, range, range.end, order);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
