#include "engine_client/broad_phase/tracy/tracy_rest.h"

#include <algorithm>
#include <atomic>
#include <limits>

#include "engine_client/broad_phase/grid/grid_search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/tracy/tracy_rest.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Lists the boxes that are not within their margins and returns their number. An invalid box counts
// as within an invalid margin.
size_t ListOutside(std::span<const Aabb> boxes, const Aabb* margins, uint32_t* outside) {
  const HWY_FULL(float) d;
  const hn::RebindToUnsigned<decltype(d)> du;
  size_t count = 0;
  ForEachRegister(d, boxes, [&](const Aabb* from, size_t at) HWY_ATTR {
    // Loads the margins; NaN marks an invalid one.
    auto x = hn::Zero(d);
    auto y = x;
    auto z = x;
    auto max_x = x;
    auto max_y = x;
    auto max_z = x;
    LoadBoxes(d, margins + at, x, y, z, max_x, max_y, max_z);
    const auto kept = hn::Eq(x, x);
    // Loads the boxes and compares them with the margins.
    auto box_x = x;
    auto box_y = x;
    auto box_z = x;
    auto box_max_x = x;
    auto box_max_y = x;
    auto box_max_z = x;
    LoadBoxes(d, from, box_x, box_y, box_z, box_max_x, box_max_y, box_max_z);
    const auto begins = hn::And(hn::Ge(box_x, x), hn::And(hn::Ge(box_y, y), hn::Ge(box_z, z)));
    const auto ends = hn::And(hn::Le(box_max_x, max_x),
                              hn::And(hn::Le(box_max_y, max_y), hn::Le(box_max_z, max_z)));
    // A valid box is listed if it is outside its margin; an invalid box, if its margin is valid.
    const auto in_x = HalveAxis(d, box_x, box_max_x);
    const auto in_y = HalveAxis(d, box_y, box_max_y);
    const auto valid = hn::And(hn::And(in_x, in_y), HalveAxis(d, box_z, box_max_z));
    const auto within = hn::And(valid, hn::And(begins, ends));
    const auto gone = hn::And(hn::Or(kept, valid), hn::Not(within));
    const auto listed = hn::And(gone, hn::FirstN(d, boxes.size() - at));
    if (hn::AllFalse(d, listed)) return;
    // Lists the indices of the boxes that have left their margins.
    const auto index = hn::Iota(du, static_cast<uint32_t>(at));
    hn::StoreU(CompressLanes(index, hn::RebindMask(du, listed)), du, outside + count);
    count += hn::CountTrue(d, listed);
  });
  return count;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(ListOutside);

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Aabb kEverywhere = {{-kInfinity, -kInfinity, -kInfinity},
                              {kInfinity, kInfinity, kInfinity}};
constexpr Aabb kInvalidMargin = {{kNan, kNan, kNan}, {kNan, kNan, kNan}};

// Among n boxes, at most kOutsideAllowance + n / kBoxesPerOutside may be outside their margins.
constexpr size_t kBoxesPerOutside = 32;
constexpr size_t kOutsideAllowance = 8;
constexpr size_t kMinPairsPerPart = 4096;
constexpr size_t kMinSlotsPerPart = 1024;

// Returns whether two boxes overlap, without the checks of Overlap (aabb.h) and without branches.
// REQUIRES: both boxes are valid.
bool ValidBoxesOverlap(const Aabb& a, const Aabb& b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis) {
    overlap &= a.min[axis] <= b.max[axis];
    overlap &= b.min[axis] <= a.max[axis];
  }
  return overlap;
}

// Ends a search when it has found more than a number of pairs, or when another request, which may
// be null, ends it. It counts pairs and not the memory of their buffers, which depends on the
// number of threads and on earlier searches. Thread-safe.
class PairLimit final : public StopRequest {
 public:
  PairLimit(StopRequest* other, size_t max_pairs) : other_(other), max_pairs_(max_pairs) {}
  bool WantsStop(uint64_t grown_bytes) noexcept override {
    const bool other_wants = other_ != nullptr && other_->WantsStop(grown_bytes);
    return other_wants || is_exceeded();
  }
  void Add(size_t pair_count) { pair_count_ += pair_count; }
  bool is_exceeded() const { return pair_count_ > max_pairs_; }

 private:
  StopRequest* const other_;
  const size_t max_pairs_;
  std::atomic<size_t> pair_count_{0};
};

// Adds the pairs of one part of a search to the limit of the whole search. A search polls once more
// when it ends, so that all its pairs are counted. Not thread-safe.
class PartLimit final : public StopRequest {
 public:
  PartLimit(PairLimit& whole, const PairBuffer& pairs)
      : whole_(whole), pairs_(pairs), known_count_(pairs.size()) {}
  bool WantsStop(uint64_t grown_bytes) noexcept override {
    whole_.Add(pairs_.size() - known_count_);
    known_count_ = pairs_.size();
    return whole_.WantsStop(grown_bytes);
  }

 private:
  PairLimit& whole_;
  const PairBuffer& pairs_;
  size_t known_count_;
};

// Returns the box enlarged by `margin` on each side. Unlike Enlarged in dbvt_margins.cc, it returns
// a valid box unchanged if the enlarged one would overflow, and NaN for an invalid box.
Aabb Enlarged(const Aabb& box, float margin) {
  Aabb enlarged = box;
  for (int axis = 0; axis < 3; ++axis) {
    enlarged.min[axis] -= margin;
    enlarged.max[axis] += margin;
  }
  return IsValid(box) && IsValid(enlarged) ? enlarged : IsValid(box) ? box : kInvalidMargin;
}

}  // namespace

size_t TracyRest::MaxOutsideCount() const { return count_ / kBoxesPerOutside + kOutsideAllowance; }

bool TracyRest::Start(Executor* executor, const GridBoxes& boxes, float margin, TracyLists& lists,
                      uint64_t& checks, StopRequest* stop) {
  count_ = boxes.size();
  outside_count_ = 0;
  margins_.EnsureDiscarding(count_ + SoaBoxes::kPadding);
  is_outside_.EnsureDiscarding(count_);
  std::fill_n(is_outside_.data(), count_, uint8_t{0});
  const bool is_loaded = ForEachBlock(stop, 0, count_, [&](size_t from, size_t to) {
    for (size_t i = from; i < to; ++i) margins_[i] = Enlarged(boxes.in_grids[i], margin);
  });
  if (!is_loaded) return true;
  std::fill_n(margins_.data() + count_, SoaBoxes::kPadding, kInvalidMargin);
  listed_.EnsureDiscarding(count_ + SoaBoxes::kPadding);
  outside_.EnsureDiscarding(MaxOutsideCount() + 1);
  const std::span<const Aabb> margins{margins_.data(), count_};
  lists.Update(executor, {margins, margins}, MaxOutsideCount(), stop);
  if (IsStopped(stop)) return true;
  kept_.Clear();
  outside_pairs_.Clear();
  const GridView view = lists.View();
  PairLimit limit(stop, kMaxKeptPerBox * count_);
  checks += parts_.Run(
      executor, lists.size(), kMinSlotsPerPart, GridView::kBatch, kept_,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        PartLimit part_limit(limit, pairs);
        return SearchGrids(view, begin, end, pairs, &part_limit);
      },
      &limit);
  if (limit.is_exceeded()) return false;
  TestPairs(executor, boxes.boxes, stop);
  checks += kept_.size();
  return true;
}

bool TracyRest::Step(Executor* executor, const GridBoxes& boxes, TracyLists& lists,
                     uint64_t& checks, StopRequest* stop) {
  if (boxes.size() != count_) return false;
  const size_t listed =
      HWY_DYNAMIC_DISPATCH(ListOutside)(boxes.in_grids, margins_.data(), listed_.data());
  if (outside_count_ + listed > MaxOutsideCount()) return false;
  AddOutside({listed_.data(), listed}, lists);
  TestPairs(executor, boxes.boxes, stop);
  checks += count_ + kept_.size();
  outside_pairs_.Clear();
  if (outside_count_ == 0) return true;
  const GridBoxes in_grids{boxes.in_grids, boxes.in_grids};
  checks += lists.SearchFor(in_grids, {outside_.data(), outside_count_}, outside_pairs_, stop);
  const auto found = outside_pairs_.pairs();
  const auto end = std::remove_if(found.begin(), found.end(), [&](const OverlapPair& pair) {
    return !Overlap(boxes.boxes[pair.a], boxes.boxes[pair.b]);
  });
  const auto count = static_cast<size_t>(end - found.begin());
  outside_pairs_.Clear();
  outside_pairs_.Advance(count);
  return true;
}

void TracyRest::AddOutside(std::span<const uint32_t> listed, TracyLists& lists) {
  for (const uint32_t object : listed) {
    if (is_outside_[object] != 0) continue;  // was outside before and is invalid now
    is_outside_[object] = 1;
    margins_[object] = kEverywhere;
    lists.Invalidate(object);
    outside_[outside_count_++] = object;
  }
}

void TracyRest::TestPairs(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop) {
  const auto pairs = kept_.pairs();
  overlaps_.EnsureDiscarding(pairs.size());
  const size_t parts = PartCount(executor, pairs.size(), kMinPairsPerPart);
  RunParts(executor, parts, [&](size_t part) {
    const PartRange range = RangeOfPart(pairs.size(), part, parts, 64);
    ForEachBlock(stop, range.begin, range.end, [&](size_t from, size_t to) {
      for (size_t k = from; k < to; ++k) {
        const OverlapPair& pair = pairs[k];
        const bool inside = (is_outside_[pair.a] | is_outside_[pair.b]) == 0;
        overlaps_[k] =
            static_cast<uint8_t>(inside & ValidBoxesOverlap(boxes[pair.a], boxes[pair.b]));
      }
    });
  });
}

void TracyRest::Append(PairBuffer& out) const {
  const auto kept = kept_.pairs();
  OverlapPair* const to = out.EnsureRoom(kept.size() + outside_pairs_.size());
  size_t count = 0;
  for (size_t k = 0; k < kept.size(); ++k) {
    to[count] = kept[k];
    count += overlaps_[k];
  }
  const auto outside = outside_pairs_.pairs();
  std::copy(outside.begin(), outside.end(), to + count);
  out.Advance(count + outside.size());
}

size_t TracyRest::native_bytes() const {
  return margins_.capacity_bytes() + is_outside_.capacity_bytes() + listed_.capacity_bytes() +
         outside_.capacity_bytes() + kept_.capacity_bytes() + overlaps_.capacity_bytes() +
         outside_pairs_.capacity_bytes() + parts_.native_bytes();
}

}  // namespace sweepstake

#endif  // HWY_ONCE
