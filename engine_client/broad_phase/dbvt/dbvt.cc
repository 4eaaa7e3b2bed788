#include "engine_client/broad_phase/dbvt/dbvt.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/dbvt/dbvt_margins.h"
#include "engine_client/broad_phase/dbvt/dbvt_query.h"
#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "engine_client/broad_phase/kd/kd_order.h"

namespace sweepstake {
namespace {

// From this share of entries to put elsewhere on, at 0.2 us each, the tree is built anew at once.
constexpr size_t kMisplacedDivisor = 8;
// The tree is built anew when the checks above those of the cheapest frame since add up to this
// many per object: 28 ns for the order and the tree at 0.27 ns per check, so that neither costs
// more than twice the best.
constexpr uint64_t kChecksPerSort = 100;
// The order is made over so many frames that each costs about a third more.
constexpr uint64_t kMostSortFrames = 6;
constexpr uint64_t kSortSpread = 3;
constexpr uint64_t kChecksPerPair = 8;  // what writing one costs
// Likewise, from this share of objects that come or go.
constexpr size_t kChangedDivisor = 4;
// At rest: of the sampled objects at most this share goes further than a step a frame.
constexpr size_t kRestlessDivisor = 32;
// Candidates cost memory: no more pairs per object than this while they are kept.
constexpr size_t kMostPairsPerObject = 16;
// Calm frames before margins are taken. Twice as many each time that they held for less than
// kShortRest frames.
constexpr uint32_t kLeastPatience = 2;
constexpr uint32_t kMostPatience = 256;
constexpr uint32_t kShortRest = 32;
// Lowest inner nodes to a part: some 1,500 objects.
constexpr size_t kLeastGroups = 8;

// Whether so many came or went at once that building the tree is cheaper than doing it one by one,
// at 0.2 us each.
bool IsOtherScene(size_t count, size_t old_count) {
  const auto [fewer, more] = std::minmax(count, old_count);
  return more - fewer > more / kChangedDivisor;
}

class Dbvt final : public BroadPhase {
 public:
  explicit Dbvt(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "DBVT"; }
  uint32_t version() const override { return 2; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return update_checks_ + pair_checks_; }
  size_t native_bytes() const override;

 private:
  void Sort(std::span<const Aabb> boxes);
  void AdoptOrder(std::span<const Aabb> boxes);
  bool AdvanceOrder(std::span<const Aabb> boxes);
  uint64_t SortFrames(size_t object_count) const;
  void TakeCount(size_t count);
  void Refit(std::span<const Aabb> boxes);
  void InsertReturning(std::span<const Aabb> boxes);
  void ConsiderRest(std::span<const Aabb> boxes, const DbvtTree::Motion& motion);
  void StopResting();

  Executor* executor_;
  DbvtTree tree_;
  DbvtMargins margins_;
  KdOrder splitter_;
  AlignedBuffer<uint32_t> order_;  // the slots of the latest sort
  size_t sorted_count_ = 0;        // objects there were when the latest sort began
  bool is_sorting_ = false;
  // Objects whose boxes do not take part; not kept up to date while at rest.
  std::vector<uint32_t> absent_;
  PairParts parts_;
  size_t pair_count_ = 0;  // found latest
  bool is_at_rest_ = false;
  uint64_t fewest_checks_ = 0;  // in a frame since the tree was built
  uint64_t excess_checks_ = 0;  // above that, since then
  uint32_t calm_frames_ = 0;
  uint32_t resting_frames_ = 0;
  uint32_t patience_ = kLeastPatience;
  uint64_t latest_cost_ = 0;  // of the latest search, in checks
  uint64_t update_checks_ = 0;
  uint64_t pair_checks_ = 0;
};

void Dbvt::Build(std::span<const Aabb> boxes) {
  Sort(boxes);
  margins_.MeasureSide(boxes);
  is_at_rest_ = false;
  calm_frames_ = 0;
  patience_ = kLeastPatience;
  pair_count_ = 0;
  update_checks_ = 0;
  pair_checks_ = 0;
}

void Dbvt::Sort(std::span<const Aabb> boxes) {
  splitter_.Begin(boxes);
  splitter_.Finish(executor_);
  sorted_count_ = boxes.size();
  AdoptOrder(boxes);
}

void Dbvt::AdoptOrder(std::span<const Aabb> boxes) {
  order_.EnsureDiscarding(KdOrder::MostSlots(sorted_count_));
  const std::span<uint32_t> slots{order_.data(), splitter_.slot_count()};
  splitter_.TakeSlots(slots);
  absent_.clear();
  tree_.Build(boxes, slots, executor_, absent_);
  for (size_t object = sorted_count_; object < boxes.size(); ++object) {
    absent_.push_back(static_cast<uint32_t>(object));
  }
  InsertReturning(boxes);
  is_sorting_ = false;
  fewest_checks_ = std::numeric_limits<uint64_t>::max();
  excess_checks_ = 0;
}

// As much of a sort as this frame is to bear. True: the tree was built anew.
bool Dbvt::AdvanceOrder(std::span<const Aabb> boxes) {
  if (!is_sorting_) {
    if (excess_checks_ <= kChecksPerSort * boxes.size()) return false;
    splitter_.Begin(boxes);
    sorted_count_ = boxes.size();
    is_sorting_ = true;
  }
  const uint64_t frames = SortFrames(boxes.size());
  if (frames == 1) {
    splitter_.Finish(executor_);
  } else if (!splitter_.Advance(splitter_.work() / frames + 1)) {
    return false;
  }
  AdoptOrder(boxes);
  return true;
}

uint64_t Dbvt::SortFrames(size_t object_count) const {
  return std::clamp(kSortSpread * kChecksPerSort * object_count / (latest_cost_ + 1), uint64_t{1},
                    kMostSortFrames);
}

void Dbvt::Update(std::span<const Aabb> boxes) {
  if (IsOtherScene(boxes.size(), tree_.object_count())) return Build(boxes);
  update_checks_ = 0;
  latest_cost_ = pair_checks_ + kChecksPerPair * pair_count_;
  pair_checks_ = 0;
  if (is_at_rest_) {
    ++resting_frames_;
    if (margins_.Follow(boxes, tree_, executor_, update_checks_)) return;
    StopResting();
  }
  TakeCount(boxes.size());
  Refit(boxes);
}

// REQUIRES: not at rest.
void Dbvt::TakeCount(size_t count) {
  const size_t old_count = tree_.object_count();
  if (count == old_count) return;
  std::erase_if(absent_, [&](uint32_t object) { return object >= count; });
  for (size_t object = count; object < old_count; ++object) {
    if (tree_.Contains(static_cast<uint32_t>(object))) tree_.Remove(static_cast<uint32_t>(object));
  }
  tree_.Resize(count);
  for (size_t object = old_count; object < count; ++object) {
    absent_.push_back(static_cast<uint32_t>(object));
  }
}

void Dbvt::Refit(std::span<const Aabb> boxes) {
  if (AdvanceOrder(boxes)) return;
  const DbvtTree::Motion motion = tree_.Refit(boxes, margins_.Step(), executor_, absent_);
  if (motion.is_upheaval || tree_.waiting_count() > boxes.size() / kMisplacedDivisor) {
    return Sort(boxes);
  }
  tree_.Settle();
  InsertReturning(boxes);
  ConsiderRest(boxes, motion);
}

void Dbvt::InsertReturning(std::span<const Aabb> boxes) {
  std::erase_if(absent_, [&](uint32_t object) {
    if (!TakesPart(boxes[object])) return false;
    tree_.Insert(object, boxes[object]);
    return true;
  });
}

void Dbvt::ConsiderRest(std::span<const Aabb> boxes, const DbvtTree::Motion& motion) {
  const bool is_calm = motion.restless <= motion.sampled / kRestlessDivisor &&
                       pair_count_ <= kMostPairsPerObject * boxes.size();
  calm_frames_ = is_calm ? calm_frames_ + 1 : 0;
  if (calm_frames_ < patience_) return;
  margins_.MeasureSide(boxes);
  if (!margins_.Start(boxes, motion.mean, tree_, executor_)) {
    calm_frames_ = 0;
    patience_ = std::min(2 * patience_, kMostPatience);
    return;
  }
  is_at_rest_ = true;
  is_sorting_ = false;
  resting_frames_ = 0;
}

void Dbvt::StopResting() {
  is_at_rest_ = false;
  calm_frames_ = 0;
  patience_ =
      resting_frames_ < kShortRest ? std::min(2 * patience_, kMostPatience) : kLeastPatience;
  absent_.clear();
  for (uint32_t object = 0; object < tree_.object_count(); ++object) {
    if (!tree_.Contains(object)) absent_.push_back(object);
  }
}

void Dbvt::FindPairs(PairBuffer& out) {
  const size_t before = out.size();
  if (is_at_rest_) {
    pair_checks_ = margins_.FindPairs(executor_, parts_, out);
  } else {
    const std::span<const uint32_t> groups = tree_.Groups();
    pair_checks_ =
        parts_.Run(executor_, groups.size(), kLeastGroups, 1, out,
                   [&](size_t begin, size_t end, PairBuffer& pairs) {
                     return FindGroupPairs(tree_, groups.subspan(begin, end - begin), pairs);
                   });
    fewest_checks_ = std::min(fewest_checks_, pair_checks_);
    excess_checks_ += pair_checks_ - fewest_checks_;
  }
  pair_count_ = out.size() - before;
}

size_t Dbvt::native_bytes() const {
  return tree_.native_bytes() + margins_.native_bytes() + splitter_.native_bytes() +
         order_.capacity_bytes() + parts_.native_bytes() + absent_.capacity() * sizeof(uint32_t);
}

}  // namespace

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options) {
  return std::make_unique<Dbvt>(options);
}

}  // namespace sweepstake
