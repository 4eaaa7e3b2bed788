#include "engine_client/broad_phase/dbvt/dbvt.h"

#include <algorithm>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/rebuild_debt.h"
#include "engine_client/broad_phase/dbvt/dbvt_margins.h"
#include "engine_client/broad_phase/dbvt/dbvt_query.h"
#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/kd/kd_order.h"

namespace sweepstake {
namespace {

// The cost of computing an order and building a tree from it, in checks per object. It is used for
// every instruction set. With half the value, the mean frame time of six scenes is 3 % shorter, but
// the slowest frames take 13 to 17 % longer (AVX-512, AVX2 and SSE4 on AMD Zen 4, `sweepstake-lab
// bench`).
constexpr uint64_t kChecksPerRebuild = 100;
// The tree is rebuilt at once if more than 1 in 8 entries would have to be inserted again.
constexpr size_t kEntriesPerMisplaced = 8;
// The tree is built from scratch if more than 1 in 4 objects is added or removed in one frame.
constexpr size_t kObjectsPerChanged = 4;
// A frame is calm if at most 1 in 32 sampled objects moves further than DbvtMargins::Step().
constexpr size_t kSamplesPerFast = 32;
// Margins are tried only in scenes with at most this number of pairs per object: the pairs of
// enlarged boxes are kept, and they take memory.
constexpr size_t kMaxPairsPerObject = 16;
// The number of calm frames before margins are tried. It doubles up to kMaxCalmFrames each time
// margins have held for fewer than kShortRest frames.
constexpr uint32_t kMinCalmFrames = 2;
constexpr uint32_t kMaxCalmFrames = 256;
constexpr uint32_t kShortRest = 32;
// The number of inserted objects between two polls of the stop request; one insertion takes 1 µs or
// less.
constexpr size_t kInsertionsPerQuestion = 2048;

bool IsOtherScene(size_t count, size_t old_count) {
  const auto [fewer, more] = std::minmax(count, old_count);
  return more - fewer > more / kObjectsPerChanged;
}

class Dbvt final : public BroadPhase {
 public:
  explicit Dbvt(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "DBVT"; }
  uint32_t version() const override { return 6; }
  void DoBuild(std::span<const Aabb> boxes) override;
  void DoUpdate(std::span<const Aabb> boxes) override;
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return update_checks_ + pair_checks_; }
  size_t native_bytes() const override;

 private:
  void Rebuild(std::span<const Aabb> boxes);
  void AdoptOrder(std::span<const Aabb> boxes);
  bool AdvanceRebuild(std::span<const Aabb> boxes);
  void Resize(size_t count);
  void Refit(std::span<const Aabb> boxes);
  void InsertReturning(std::span<const Aabb> boxes);
  void MaybeUseMargins(std::span<const Aabb> boxes, const DbvtTree::Motion& motion);
  void StopResting();
  void WaitLonger() { calm_frames_needed_ = std::min(2 * calm_frames_needed_, kMaxCalmFrames); }

  Executor* executor_;
  DbvtTree tree_;
  DbvtMargins margins_;
  KdOrder splitter_;
  AlignedBuffer<uint32_t> order_;  // the objects in the order of the latest rebuild
  size_t ordered_count_ = 0;       // the number of objects when the latest order was begun
  bool is_ordering_ = false;
  RebuildDebt debt_;  // the tree's extra checks since the latest rebuild
  // The objects that are not in the tree because their boxes are invalid. While the tree holds
  // boxes enlarged by margins (is_at_rest_), the list is out of date.
  HookedVector<uint32_t> outside_;
  PairParts parts_;
  size_t pair_count_ = 0;  // the number of pairs of the latest search
  bool is_at_rest_ = false;
  uint32_t calm_frames_ = 0;
  uint32_t resting_frames_ = 0;
  uint32_t calm_frames_needed_ = kMinCalmFrames;
  uint64_t latest_cost_ = 0;  // the cost of the latest search, in checks
  uint64_t update_checks_ = 0;
  uint64_t pair_checks_ = 0;
};

void Dbvt::DoBuild(std::span<const Aabb> boxes) {
  Rebuild(boxes);
  margins_.MeasureSide(boxes);
  is_at_rest_ = false;
  calm_frames_ = 0;
  calm_frames_needed_ = kMinCalmFrames;
  pair_count_ = 0;
  update_checks_ = 0;
  pair_checks_ = 0;
}

void Dbvt::Rebuild(std::span<const Aabb> boxes) {
  splitter_.Begin(boxes);
  if (!splitter_.Finish(executor_, stop())) return;
  ordered_count_ = boxes.size();
  AdoptOrder(boxes);
}

// Builds the tree in the completed order. Then inserts the objects that were added while the order
// was being computed.
void Dbvt::AdoptOrder(std::span<const Aabb> boxes) {
  order_.EnsureDiscarding(KdOrder::MaxSlots(ordered_count_));
  const std::span<uint32_t> slots{order_.data(), splitter_.slot_count()};
  splitter_.TakeSlots(slots);
  outside_.clear();
  tree_.Build(boxes, slots, executor_, outside_, stop());
  if (IsStopped(stop())) return;
  for (size_t object = ordered_count_; object < boxes.size(); ++object) {
    outside_.push_back(static_cast<uint32_t>(object));
  }
  InsertReturning(boxes);
  is_ordering_ = false;
  debt_.Clear();
}

// If a rebuild is due, computes a part of the new order, and rebuilds the tree when the order is
// complete. Returns whether the tree was rebuilt or the call was stopped.
bool Dbvt::AdvanceRebuild(std::span<const Aabb> boxes) {
  if (!is_ordering_) {
    if (!debt_.Exceeds(kChecksPerRebuild * boxes.size())) return false;
    splitter_.Begin(boxes);
    ordered_count_ = boxes.size();
    is_ordering_ = true;
  }
  const uint64_t frames = RebuildFrames(kChecksPerRebuild * boxes.size(), latest_cost_);
  if (frames == 1) {
    if (!splitter_.Finish(executor_, stop())) return true;
  } else if (!splitter_.Advance(splitter_.work() / frames + 1)) {
    return false;
  }
  AdoptOrder(boxes);
  return true;
}

void Dbvt::DoUpdate(std::span<const Aabb> boxes) {
  if (IsOtherScene(boxes.size(), tree_.object_count())) return DoBuild(boxes);
  update_checks_ = 0;
  latest_cost_ = SearchCost(pair_checks_, pair_count_);
  pair_checks_ = 0;
  if (is_at_rest_) {
    ++resting_frames_;
    if (margins_.Follow(boxes, tree_, executor_, update_checks_, stop())) return;
    StopResting();
  }
  Resize(boxes.size());
  Refit(boxes);
}

// Adds objects to outside_, or removes the last objects. REQUIRES: is_at_rest_ is false.
void Dbvt::Resize(size_t count) {
  const size_t old_count = tree_.object_count();
  if (count == old_count) return;
  std::erase_if(outside_, [&](uint32_t object) { return object >= count; });
  for (size_t object = count; object < old_count; ++object) {
    if (tree_.Contains(static_cast<uint32_t>(object))) tree_.Remove(static_cast<uint32_t>(object));
  }
  tree_.Resize(count);
  for (size_t object = old_count; object < count; ++object) {
    outside_.push_back(static_cast<uint32_t>(object));
  }
}

void Dbvt::Refit(std::span<const Aabb> boxes) {
  if (AdvanceRebuild(boxes)) return;
  const DbvtTree::Motion motion = tree_.Refit(boxes, margins_.Step(), executor_, outside_);
  if (IsStopped(stop())) return;
  if (motion.needs_build || tree_.waiting_count() > boxes.size() / kEntriesPerMisplaced) {
    return Rebuild(boxes);
  }
  tree_.Settle(stop());
  InsertReturning(boxes);
  if (IsStopped(stop())) return;
  MaybeUseMargins(boxes, motion);
}

// Inserts the objects of outside_ whose boxes are valid again. If the call is stopped, the others
// stay in outside_.
void Dbvt::InsertReturning(std::span<const Aabb> boxes) {
  size_t valid = 0;
  bool is_stopped = false;
  std::erase_if(outside_, [&](uint32_t object) {
    if (!IsValid(boxes[object])) return false;
    if (valid++ % kInsertionsPerQuestion == 0) is_stopped = IsStopped(stop());
    if (is_stopped) return false;
    tree_.Insert(object, boxes[object]);
    return true;
  });
}

// Starts to use margins after enough calm frames in a row.
void Dbvt::MaybeUseMargins(std::span<const Aabb> boxes, const DbvtTree::Motion& motion) {
  const bool is_calm = motion.fast_count <= motion.sample_count / kSamplesPerFast &&
                       pair_count_ <= kMaxPairsPerObject * boxes.size();
  calm_frames_ = is_calm ? calm_frames_ + 1 : 0;
  if (calm_frames_ < calm_frames_needed_) return;
  margins_.MeasureSide(boxes);
  if (!margins_.Start(boxes, motion.mean, tree_, executor_, stop())) {
    calm_frames_ = 0;
    WaitLonger();
    return;
  }
  is_at_rest_ = true;
  is_ordering_ = false;
  resting_frames_ = 0;
}

void Dbvt::StopResting() {
  is_at_rest_ = false;
  calm_frames_ = 0;
  if (resting_frames_ < kShortRest) {
    WaitLonger();
  } else {
    calm_frames_needed_ = kMinCalmFrames;
  }
  outside_.clear();
  for (uint32_t object = 0; object < tree_.object_count(); ++object) {
    if (!tree_.Contains(object)) outside_.push_back(object);
  }
}

void Dbvt::DoFindPairs(PairBuffer& out) {
  const size_t before = out.size();
  if (is_at_rest_) {
    pair_checks_ = margins_.FindPairs(executor_, parts_, out);
  } else {
    const std::span<const uint32_t> groups = tree_.Groups();
    pair_checks_ = parts_.Run(
        executor_, groups.size(), kMinGroupsPerPart, 1, out,
        [&](size_t begin, size_t end, PairBuffer& pairs) {
          return FindGroupPairs(tree_, groups.subspan(begin, end - begin), pairs, stop());
        },
        stop());
    debt_.AddSearch(pair_checks_);
  }
  pair_count_ = out.size() - before;
}

size_t Dbvt::native_bytes() const {
  return tree_.native_bytes() + margins_.native_bytes() + splitter_.native_bytes() +
         order_.capacity_bytes() + parts_.native_bytes() + outside_.capacity() * sizeof(uint32_t);
}

}  // namespace

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options) {
  return std::make_unique<Dbvt>(options);
}

}  // namespace sweepstake
