#include "engine_client/broad_phase/tracy/tracy.h"

#include <algorithm>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/rebuild_debt.h"
#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/grid/grid_search.h"
#include "engine_client/broad_phase/tracy/tracy_lists.h"
#include "engine_client/broad_phase/tracy/tracy_rest.h"
#include "engine_client/broad_phase/tracy/tracy_rows.h"

namespace sweepstake {
namespace {

// About what laying out anew costs.
constexpr uint64_t kChecksPerLayout = 256;
// Checks per box, and per pair, above which another layout is tried, though not often: the scene
// may have spread since, or be as dense as that.
constexpr uint64_t kFairChecksPerBox = 128;
constexpr uint64_t kFairChecksPerPair = 16;
constexpr uint32_t kFramesPerTrial = 64;
// One box in so many may be too long for the cells it has, and some more.
constexpr size_t kBoxesPerLongOne = 64;
constexpr size_t kFewLongBoxes = 16;
// Little moves when so few boxes cross into another list: one in so many.
constexpr size_t kBoxesPerCrossing = 128;
// Margins in cells: wide enough to hold slow boxes for many frames, and few more pairs to test.
constexpr float kMarginsPerCell = 48;
// Where there are more pairs, testing those kept costs as much as finding them.
constexpr size_t kMostPairsPerBox = 8;
// Frames for which margins have to hold to be worth it, and frames until they are tried again where
// they did not, doubled each time.
constexpr uint32_t kWorthwhileRest = 6;
constexpr uint32_t kLongestWait = 256;
// About 25 µs of work.
constexpr size_t kLeastBoxesPerPart = 1024;

class Tracy final : public BroadPhase {
 public:
  explicit Tracy(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "Tracy"; }
  uint32_t version() const override { return 2; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return lists_.native_bytes() + rest_.native_bytes() + parts_.native_bytes();
  }

 private:
  void LayOut(std::span<const Aabb> boxes);
  bool TakeAtRest(std::span<const Aabb> boxes);
  void StartResting(std::span<const Aabb> boxes);
  void TakeInMotion(std::span<const Aabb> boxes);

  Executor* executor_;
  GridPlan plan_;
  TracyLists lists_;
  PairParts parts_;
  TracyRest rest_;
  bool resting_ = false;
  uint32_t rested_ = 0;  // frames since margins were last taken
  uint32_t wait_ = 0;    // frames until they may be
  uint32_t last_wait_ = 1;
  size_t pair_count_ = 0;  // of the latest search
  uint32_t frames_ = 0;    // since the grids were laid out
  bool unfair_ = false;    // the latest search took more checks than it should
  RebuildDebt debt_;       // since the grids were laid out
  uint64_t checks_ = 0;
};

void Tracy::Build(std::span<const Aabb> boxes) {
  wait_ = 0;
  last_wait_ = 1;
  pair_count_ = 0;
  LayOut(boxes);
}

void Tracy::LayOut(std::span<const Aabb> boxes) {
  checks_ = 0;
  plan_.Reset();
  plan_.MakeGrids(executor_, boxes);
  lists_.Reset(RowGrids(plan_));
  lists_.Update(executor_, boxes);
  debt_.Clear();
  frames_ = 0;
  unfair_ = false;
  resting_ = false;
}

void Tracy::Update(std::span<const Aabb> boxes) {
  checks_ = 0;
  if (resting_ && TakeAtRest(boxes)) return;
  if (wait_ == 0 && pair_count_ < kMostPairsPerBox * boxes.size() &&
      lists_.moved_count() * kBoxesPerCrossing < boxes.size()) {
    StartResting(boxes);
  } else {
    TakeInMotion(boxes);
  }
}

// False: the margins no longer hold.
bool Tracy::TakeAtRest(std::span<const Aabb> boxes) {
  ++rested_;
  if (rest_.Step(executor_, boxes, lists_, checks_)) return true;
  resting_ = false;
  if (rested_ >= kWorthwhileRest) {
    last_wait_ = 1;
    StartResting(boxes);
    return true;
  }
  last_wait_ = std::min(2 * last_wait_, kLongestWait);
  wait_ = last_wait_;
  lists_.SetMargin(0);
  return false;
}

void Tracy::StartResting(std::span<const Aabb> boxes) {
  const float margin = lists_.narrowest_cell() / kMarginsPerCell;
  lists_.SetMargin(margin);
  checks_ += rest_.Start(executor_, boxes, margin, lists_);
  resting_ = true;
  rested_ = 0;
}

void Tracy::TakeInMotion(std::span<const Aabb> boxes) {
  ++frames_;
  if (wait_ > 0) --wait_;
  const bool try_anew = unfair_ && frames_ >= kFramesPerTrial;
  if (try_anew || debt_.Exceeds(kChecksPerLayout * boxes.size())) return LayOut(boxes);
  lists_.Update(executor_, boxes);
  if (lists_.long_count() > boxes.size() / kBoxesPerLongOne + kFewLongBoxes) LayOut(boxes);
}

void Tracy::FindPairs(PairBuffer& out) {
  if (resting_) return rest_.Append(out);
  const GridView view = lists_.View();
  const size_t before = out.size();
  checks_ = parts_.Run(executor_, lists_.size(), kLeastBoxesPerPart, GridView::kBatch, out,
                       [&](size_t begin, size_t end, PairBuffer& pairs) {
                         return SearchGrids(view, begin, end, pairs);
                       });
  debt_.AddSearch(checks_);
  pair_count_ = out.size() - before;
  unfair_ = checks_ > kFairChecksPerBox * lists_.size() + kFairChecksPerPair * pair_count_;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options) {
  return std::make_unique<Tracy>(options);
}

}  // namespace sweepstake
