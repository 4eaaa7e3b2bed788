#include "engine_client/broad_phase/dbvt.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/dbvt_query.h"
#include "engine_client/broad_phase/dbvt_tree.h"
#include "engine_client/broad_phase/leaf_tree.h"
#include "engine_client/broad_phase/soa_boxes.h"

namespace sweepstake {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();

// Margins as shares of the typical side, and in frames of motion.
constexpr float kLeastMargin = 0.02F;
constexpr float kMostMargin = 0.3F;
constexpr float kMarginFrames = 4;
// From this share of moved boxes on, one refit and one search for all is cheaper than reinsertions:
// 0.9 us each against 60 ns per box at 10,000.
constexpr size_t kBulkDivisor = 20;
// Refitted moves per object after which the tree is split anew.
constexpr size_t kMovesPerRebuild = 8;
// A box that goes further than this many typical sides at once counts as kMovesPerRebuild moves:
// its place in the tree is void.
constexpr float kFarSides = 8;
// Enough for a median that only scales a margin.
constexpr size_t kSideSample = 512;

constexpr PackedBox kAbsent = {{kInfinity, kInfinity, kInfinity, 0},
                               {-kInfinity, -kInfinity, -kInfinity, 0}};

PackedBox Pack(const Aabb& box) {
  return {{box.min[0], box.min[1], box.min[2], 0}, {box.max[0], box.max[1], box.max[2], 0}};
}

bool IsInside(const Aabb& box, const DbvtNode& fat) {
  bool inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    inside &= box.min[axis] >= fat.min[axis];
    inside &= box.max[axis] <= fat.max[axis];
  }
  return inside;
}

// May be infinite.
float LongestSide(const Aabb& box) {
  return std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
}

// Largest step on an axis; infinite when the box was absent.
float Motion(const PackedBox& from, const Aabb& to) {
  float motion = 0;
  for (int axis = 0; axis < 3; ++axis)
    motion = std::max(motion, std::abs(to.min[axis] - from.min[axis]));
  return motion;
}

Aabb Enlarged(const Aabb& box, float margin) {
  Aabb fat = box;
  for (int axis = 0; axis < 3; ++axis) {
    fat.min[axis] = std::max(box.min[axis] - margin, -kLargest);
    fat.max[axis] = std::min(box.max[axis] + margin, kLargest);
  }
  return fat;
}

class Dbvt final : public BroadPhase {
 public:
  explicit Dbvt(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "DBVT"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return update_checks_ + pair_checks_; }
  size_t native_bytes() const override;

 private:
  // A box that is no longer inside its leaf, or came or went.
  struct Moved {
    float margin;
    bool takes_part;
  };

  void MeasureTypicalSide(std::span<const Aabb> boxes);
  float MarginFor(float motion) const;
  void CollectMoved(std::span<const Aabb> boxes);
  void Take(uint32_t object, const Aabb& box);
  void MoveInBulk(std::span<const Aabb> boxes);
  void MoveOneByOne(std::span<const Aabb> boxes);
  void FindAllCandidates();
  void DropCandidatesOfMoved();

  DbvtTree tree_;
  PairBuffer candidates_;
  std::vector<PackedBox> exact_;
  // The leaves once more, in the tree's order, for frames that look at them all.
  std::vector<Aabb> fat_;
  SoaBoxes leaves_;
  LeafTree packed_;
  std::vector<uint32_t> moved_;
  std::vector<float> margins_;  // of moved_
  std::vector<uint8_t> is_moved_;
  std::vector<float> sides_;
  float typical_side_ = 0;
  size_t refitted_moves_ = 0;  // since the tree was split anew
  size_t far_moves_ = 0;       // in the latest Update
  uint64_t update_checks_ = 0;
  uint64_t pair_checks_ = 0;
};

// Median longest side of an even sample of the boxes that take part.
void Dbvt::MeasureTypicalSide(std::span<const Aabb> boxes) {
  sides_.clear();
  const size_t stride = boxes.size() / kSideSample + 1;
  for (size_t i = 0; i < boxes.size(); i += stride) {
    if (TakesPart(boxes[i])) sides_.push_back(std::min(LongestSide(boxes[i]), kLargest));
  }
  if (sides_.empty()) {
    typical_side_ = 0;
    return;
  }
  const auto middle = sides_.begin() + static_cast<std::ptrdiff_t>(sides_.size() / 2);
  std::nth_element(sides_.begin(), middle, sides_.end());
  typical_side_ = *middle;
}

float Dbvt::MarginFor(float motion) const {
  const float least = kLeastMargin * typical_side_;
  const float most = kMostMargin * typical_side_;
  if (motion > most) return least;
  return std::clamp(kMarginFrames * motion, least, most);
}

void Dbvt::Build(std::span<const Aabb> boxes) {
  tree_.Reset(boxes.size());
  exact_.resize(boxes.size());
  fat_.resize(boxes.size());
  is_moved_.assign(boxes.size(), 0);
  moved_.reserve(boxes.size());
  margins_.reserve(boxes.size());
  sides_.reserve(kSideSample + 1);
  MeasureTypicalSide(boxes);
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    exact_[i] = kAbsent;
    if (!TakesPart(boxes[i])) continue;
    exact_[i] = Pack(boxes[i]);
    tree_.SetBox(i, Enlarged(boxes[i], MarginFor(0)));
  }
  tree_.Rebuild();
  refitted_moves_ = 0;
  update_checks_ = 0;
  pair_checks_ = 0;
  FindAllCandidates();
}

void Dbvt::Update(std::span<const Aabb> boxes) {
  if (boxes.size() != exact_.size()) return Build(boxes);
  update_checks_ = 0;
  pair_checks_ = 0;
  CollectMoved(boxes);
  if (moved_.size() > boxes.size() / kBulkDivisor) {
    MoveInBulk(boxes);
  } else if (!moved_.empty()) {
    MoveOneByOne(boxes);
  }
  for (const uint32_t object : moved_) is_moved_[object] = 0;
}

void Dbvt::CollectMoved(std::span<const Aabb> boxes) {
  moved_.clear();
  margins_.clear();
  far_moves_ = 0;
  for (uint32_t i = 0; i < boxes.size(); ++i) Take(i, boxes[i]);
}

void Dbvt::Take(uint32_t object, const Aabb& box) {
  PackedBox& exact = exact_[object];
  const bool was_present = tree_.Contains(object);
  if (!TakesPart(box)) {
    exact = kAbsent;
    if (!was_present) return;
  } else {
    const float motion = Motion(exact, box);
    if (typical_side_ > 0 && motion > kFarSides * typical_side_) ++far_moves_;
    exact = Pack(box);
    ++update_checks_;
    if (was_present && IsInside(box, tree_.nodes()[object])) return;
    margins_.push_back(MarginFor(motion));
    moved_.push_back(object);
    is_moved_[object] = 1;
    return;
  }
  margins_.push_back(0);
  moved_.push_back(object);
  is_moved_[object] = 1;
}

void Dbvt::MoveInBulk(std::span<const Aabb> boxes) {
  bool any_added = false;
  for (size_t k = 0; k < moved_.size(); ++k) {
    const uint32_t object = moved_[k];
    if (!TakesPart(boxes[object])) {
      tree_.Remove(object);
      continue;
    }
    any_added |= !tree_.Contains(object);
    tree_.SetBox(object, Enlarged(boxes[object], margins_[k]));
  }
  refitted_moves_ += moved_.size() + kMovesPerRebuild * far_moves_;
  if (any_added || refitted_moves_ > kMovesPerRebuild * boxes.size()) {
    MeasureTypicalSide(boxes);
    tree_.Rebuild();
    refitted_moves_ = 0;
  } else {
    tree_.Refit();
  }
  FindAllCandidates();
}

void Dbvt::MoveOneByOne(std::span<const Aabb> boxes) {
  for (size_t k = 0; k < moved_.size(); ++k) {
    const uint32_t object = moved_[k];
    const Aabb fat = Enlarged(boxes[object], margins_[k]);
    if (!TakesPart(boxes[object])) {
      tree_.Remove(object);
    } else if (tree_.Contains(object)) {
      tree_.Move(object, fat);
    } else {
      tree_.Insert(object, fat);
    }
  }
  DropCandidatesOfMoved();
  update_checks_ += FindLeafPairsOf(tree_, moved_, is_moved_.data(), candidates_);
}

// Sixteen leaves of the tree's order at a time: 5 to 10 times as fast as one by one from the root.
void Dbvt::FindAllCandidates() {
  for (const uint32_t leaf : tree_.order()) fat_[leaf] = tree_.box(leaf);
  leaves_.Gather(fat_, tree_.order());
  packed_.Refit(leaves_.Lanes());
  candidates_.Clear();
  update_checks_ += packed_.FindPairs(leaves_.Lanes(), candidates_);
}

void Dbvt::DropCandidatesOfMoved() {
  const std::span<OverlapPair> candidates = candidates_.pairs();
  size_t kept = 0;
  for (const OverlapPair& pair : candidates) {
    candidates[kept] = pair;
    kept += (is_moved_[pair.a] | is_moved_[pair.b]) == 0 ? 1 : 0;
  }
  candidates_.Clear();
  candidates_.Advance(kept);
}

void Dbvt::FindPairs(PairBuffer& out) {
  pair_checks_ = KeepOverlapping(candidates_.pairs(), exact_.data(), out);
}

size_t Dbvt::native_bytes() const {
  return tree_.native_bytes() + candidates_.capacity_bytes() +
         exact_.capacity() * sizeof(PackedBox) + fat_.capacity() * sizeof(Aabb) +
         leaves_.native_bytes() + packed_.native_bytes() + moved_.capacity() * sizeof(uint32_t) +
         (margins_.capacity() + sides_.capacity()) * sizeof(float) + is_moved_.capacity();
}

}  // namespace

std::unique_ptr<BroadPhase> MakeDbvt(const BroadPhaseOptions& options) {
  return std::make_unique<Dbvt>(options);
}

}  // namespace sweepstake
