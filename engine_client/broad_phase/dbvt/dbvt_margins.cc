#include "engine_client/broad_phase/dbvt/dbvt_margins.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/pair_limit.h"
#include "engine_client/broad_phase/dbvt/dbvt_query.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/dbvt/dbvt_margins.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE bool BoxesOverlap(const Aabb& a, const Aabb& b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap &= a.min[axis] <= b.max[axis];
    overlap &= a.max[axis] >= b.min[axis];
  }
  return overlap;
}

// Returns whether `box` is valid and inside the enlarged box `fat`.
HWY_INLINE bool IsInside(const Aabb& box, const Aabb& fat) {
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    inside &= box.min[axis] <= box.max[axis];
    inside &= box.min[axis] >= fat.min[axis];
    inside &= box.max[axis] <= fat.max[axis];
  }
  return inside;
}

#else

using Half = hn::FixedTag<float, 4>;

// Does the same as RecordsOverlap (box_record-inl.h), for boxes that are not padded to whole
// registers. Copying all boxes to records in every frame would cost more than it saves.
HWY_INLINE bool BoxesOverlap(const Aabb& a, const Aabb& b) {
  const Half d;
  const auto overlap = hn::And(hn::Le(hn::LoadU(d, a.min), hn::LoadU(d, b.max)),
                               hn::Ge(hn::LoadU(d, a.max), hn::LoadU(d, b.min)));
  // The fourth lane holds the float that follows the corner in memory and is ignored.
  return hn::AllTrue(d, hn::Or(overlap, hn::Not(hn::FirstN(d, 3))));
}

// Returns whether `box` is valid and inside the enlarged box `fat`.
HWY_INLINE bool IsInside(const Aabb& box, const Aabb& fat) {
  const Half d;
  const auto min = hn::LoadU(d, box.min);
  // Loads from one float before the max corner on, so that nothing behind the last box is read.
  const auto max = hn::LoadU(d, box.min + 2);
  const auto ordered = hn::Le(min, hn::Shuffle0321(max));
  const auto low = hn::And(ordered, hn::Ge(min, hn::LoadU(d, fat.min)));
  const auto high = hn::Le(max, hn::LoadU(d, fat.min + 2));
  const auto not_low = hn::Not(hn::FirstN(d, 3));
  return hn::AllTrue(d, hn::And(hn::Or(low, not_low), hn::Or(high, hn::FirstN(d, 1))));
}

#endif

uint64_t KeepOverlapping(std::span<const OverlapPair> candidates, const Aabb* HWY_RESTRICT boxes,
                         PairBuffer& out) {
  OverlapPair* const kept = out.EnsureRoom(candidates.size());
  size_t count = 0;
  for (const OverlapPair& pair : candidates) {
    kept[count] = pair;
    count += BoxesOverlap(boxes[pair.a], boxes[pair.b]) ? 1 : 0;
  }
  out.Advance(count);
  return candidates.size();
}

// Lists in `left` the objects of [begin, end) that are outside their enlarged boxes. Returns their
// number.
size_t CollectOutside(const Aabb* boxes, const Aabb* HWY_RESTRICT fat, size_t begin, size_t end,
                      uint32_t* HWY_RESTRICT left) {
  size_t count = 0;
  for (size_t object = begin; object < end; ++object) {
    left[count] = static_cast<uint32_t>(object);
    count += IsInside(boxes[object], fat[object]) ? 0 : 1;
  }
  return count;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(KeepOverlapping);
HWY_EXPORT(CollectOutside);

namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

// The bounds of a margin, as multiples of the typical side (dbvt_margins.h).
constexpr float kMinMargin = 0.02F;
constexpr float kMaxMargin = 0.1F;
// A margin is the motion of its object in this number of frames, clamped to the bounds above.
constexpr float kMarginFrames = 8;
// Margins are dropped if more than 1 in 20 objects leaves its margin in a frame. One refit and one
// search for all objects then cost less than new margins and candidates for these objects.
constexpr size_t kObjectsPerOutside = 20;
// The maximum number of candidates (pairs of enlarged boxes that overlap) per object. Testing more
// takes longer than a search in the tree. It is 1.5 times kMaxPairsPerObject (dbvt.cc), the limit
// up to which DBVT tries margins.
constexpr size_t kMaxCandidatesPerObject = 24;
// The maximum number of boxes from which the median side is estimated. A rough estimate is enough,
// since the median only scales the margins.
constexpr size_t kSideSampleSize = 512;
// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinBoxesPerPart = 8192;
constexpr size_t kMinCandidatesPerPart = 8192;

bool IsInvalid(const Aabb& fat) { return fat.min[0] > fat.max[0]; }

// Returns the second longest of the three sides; the result may be infinite. Margins are a fraction
// of this side. A fraction of the longest side would be too much for a long box, and a fraction of
// the shortest would leave a flat box without a margin.
float MiddleSide(const Aabb& box) {
  const float x = box.max[0] - box.min[0];
  const float y = box.max[1] - box.min[1];
  const float z = box.max[2] - box.min[2];
  return std::max(std::min(x, y), std::min(std::max(x, y), z));
}

// Returns the largest distance that the box has moved on any axis; infinite if it was invalid
// before.
float Motion(const Aabb& from, const Aabb& to) {
  float motion = 0;
  for (int axis = 0; axis < 3; ++axis) {
    motion = std::max(motion, std::abs(to.min[axis] - from.min[axis]));
  }
  return motion;
}

Aabb Enlarged(const Aabb& box, float margin) {
  if (!IsValid(box)) return kInvalidAabb;
  Aabb fat;
  for (int axis = 0; axis < 3; ++axis) {
    fat.min[axis] = std::max(box.min[axis] - margin, -kLargest);
    fat.max[axis] = std::min(box.max[axis] + margin, kLargest);
  }
  return fat;
}

}  // namespace

// Sets side_ to the median of MiddleSide over a sample: every k-th box, with k chosen so that there
// are at most kSideSampleSize of them. Invalid boxes are left out.
void DbvtMargins::MeasureSide(std::span<const Aabb> boxes) {
  sides_.reserve(kSideSampleSize + 1);
  sides_.clear();
  const size_t stride = boxes.size() / kSideSampleSize + 1;
  for (size_t i = 0; i < boxes.size(); i += stride) {
    if (IsValid(boxes[i])) sides_.push_back(std::min(MiddleSide(boxes[i]), kLargest));
  }
  side_ = 0;
  if (sides_.empty()) return;
  const auto middle = sides_.begin() + static_cast<std::ptrdiff_t>(sides_.size() / 2);
  std::nth_element(sides_.begin(), middle, sides_.end());
  side_ = *middle;
}

float DbvtMargins::Step() const { return kMaxMargin / kMarginFrames * side_; }

float DbvtMargins::MarginFor(float motion) const {
  const float min_margin = kMinMargin * side_;
  const float max_margin = kMaxMargin * side_;
  if (motion > max_margin) return min_margin;
  return std::clamp(kMarginFrames * motion, min_margin, max_margin);
}

void DbvtMargins::Reserve(size_t count, size_t kept) {
  exact_.EnsureKeeping(count + 1, kept);
  fat_.EnsureKeeping(count, kept);
  left_.EnsureDiscarding(count);
  has_left_.EnsureDiscarding(count);
  count_ = count;
}

bool DbvtMargins::Start(std::span<const Aabb> boxes, float motion, DbvtTree& tree,
                        Executor* executor, StopRequest* stop) {
  Reserve(boxes.size(), 0);
  const float margin = MarginFor(motion);
  for (size_t object = 0; object < boxes.size(); ++object) {
    exact_[object] = boxes[object];
    fat_[object] = Enlarged(boxes[object], margin);
    has_left_[object] = 0;
  }
  tree.TakeBoxes({fat_.data(), count_}, executor);
  candidates_.Clear();
  PairLimit limit(stop, MaxCandidateCount());
  FindGroupPairs(tree, tree.Groups(), candidates_, &limit);
  if (AreWorthKeeping()) return true;
  tree.TakeBoxes(boxes, executor);
  return false;
}

bool DbvtMargins::AreWorthKeeping() const { return candidates_.size() <= MaxCandidateCount(); }

size_t DbvtMargins::MaxCandidateCount() const { return kMaxCandidatesPerObject * count_; }

void DbvtMargins::Resize(size_t count, DbvtTree& tree) {
  for (size_t object = count; object < count_; ++object) {
    if (tree.Contains(static_cast<uint32_t>(object))) tree.Remove(static_cast<uint32_t>(object));
  }
  tree.Resize(count);
  if (count < count_) {
    const auto is_gone = [&](const OverlapPair& pair) { return pair.b >= count; };
    const auto pairs = candidates_.pairs();
    const auto kept = std::remove_if(pairs.begin(), pairs.end(), is_gone) - pairs.begin();
    candidates_.Clear();
    candidates_.Advance(static_cast<size_t>(kept));
  }
  const size_t kept = std::min(count, count_);
  Reserve(count, kept);
  std::fill_n(exact_.data() + kept, count - kept, kInvalidAabb);
  std::fill_n(fat_.data() + kept, count - kept, kInvalidAabb);
  std::fill_n(has_left_.data(), count, uint8_t{0});
}

bool DbvtMargins::Follow(std::span<const Aabb> boxes, DbvtTree& tree, Executor* executor,
                         uint64_t& checks, StopRequest* stop) {
  if (boxes.size() != count_) Resize(boxes.size(), tree);
  CollectObjectsOutside(boxes, executor);
  checks += count_;
  if (left_count_ > count_ / kObjectsPerOutside) return false;
  if (left_count_ == 0) return true;
  const std::span<const uint32_t> left{left_.data(), left_count_};
  for (const uint32_t object : left) Replace(object, tree);
  DropOutdatedCandidates();
  PairLimit limit(stop, MaxCandidateCount());
  checks += FindPairsOf(tree, left, fat_.data(), has_left_.data(), candidates_, &limit);
  for (const uint32_t object : left) has_left_[object] = 0;
  return AreWorthKeeping();
}

void DbvtMargins::CollectObjectsOutside(std::span<const Aabb> boxes, Executor* executor) {
  const size_t part_count = PartCount(executor, count_, kMinBoxesPerPart);
  left_counts_.resize(std::max(left_counts_.size(), part_count));
  RunParts(executor, part_count, [&](size_t part) {
    const PartRange range = RangeOfPart(count_, part, part_count, 1);
    left_counts_[part] = UpdatePart(boxes, range.begin, range.end);
  });
  left_count_ = 0;
  for (size_t part = 0; part < part_count; ++part) {
    const uint32_t* const from = left_.data() + RangeOfPart(count_, part, part_count, 1).begin;
    std::copy(from, from + left_counts_[part], left_.data() + left_count_);
    left_count_ += left_counts_[part];
  }
}

// Lists in left_, from left_[begin] on, the objects of [begin, end) that have left their margins.
// Gives each of them a new enlarged box. Returns the number of listed objects.
size_t DbvtMargins::UpdatePart(std::span<const Aabb> boxes, size_t begin, size_t end) {
  uint32_t* const left = left_.data() + begin;
  const size_t outside =
      HWY_DYNAMIC_DISPATCH(CollectOutside)(boxes.data(), fat_.data(), begin, end, left);
  size_t count = 0;
  for (size_t k = 0; k < outside; ++k) {
    const uint32_t object = left[k];
    const bool was_invalid = IsInvalid(fat_[object]);
    fat_[object] = Enlarged(boxes[object], MarginFor(Motion(exact_[object], boxes[object])));
    left[count] = object;
    count += was_invalid && IsInvalid(fat_[object]) ? 0 : 1;
  }
  std::copy(boxes.begin() + static_cast<std::ptrdiff_t>(begin),
            boxes.begin() + static_cast<std::ptrdiff_t>(end), exact_.data() + begin);
  return count;
}

// Moves an object that has left its margin to its new place in the tree, or removes it if its box
// is invalid.
void DbvtMargins::Replace(uint32_t object, DbvtTree& tree) {
  has_left_[object] = 1;
  if (IsInvalid(fat_[object])) {
    tree.Remove(object);
  } else if (tree.Contains(object)) {
    tree.Move(object, fat_[object]);
  } else {
    tree.Insert(object, fat_[object]);
  }
}

// Drops the candidates of objects that have left their margins. Few objects have left, so that the
// processor predicts the branch well. Branchless code would be slower: the address of each store
// would depend on the flags of all candidates before it.
void DbvtMargins::DropOutdatedCandidates() {
  const std::span<OverlapPair> candidates = candidates_.pairs();
  OverlapPair* kept = candidates.data();
  for (const OverlapPair& pair : candidates) {
    if ((has_left_[pair.a] | has_left_[pair.b]) != 0) continue;
    *kept++ = pair;
  }
  candidates_.Clear();
  candidates_.Advance(static_cast<size_t>(kept - candidates.data()));
}

uint64_t DbvtMargins::FindPairs(Executor* executor, PairParts& parts, PairBuffer& out) {
  const std::span<const OverlapPair> candidates = candidates_.pairs();
  return parts.Run(executor, candidates.size(), kMinCandidatesPerPart, 1, out,
                   [&](size_t begin, size_t end, PairBuffer& pairs) {
                     return HWY_DYNAMIC_DISPATCH(KeepOverlapping)(
                         candidates.subspan(begin, end - begin), exact_.data(), pairs);
                   });
}

size_t DbvtMargins::native_bytes() const {
  return exact_.capacity_bytes() + fat_.capacity_bytes() + left_.capacity_bytes() +
         has_left_.capacity_bytes() + left_counts_.capacity() * sizeof(size_t) +
         sides_.capacity() * sizeof(float) + candidates_.capacity_bytes();
}

}  // namespace sweepstake

#endif  // HWY_ONCE
