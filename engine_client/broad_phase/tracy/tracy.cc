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

// The approximate cost of a new layout, in checks per box. Half or twice the value changes the time
// of a frame by 3 % or less with AVX2 and SSE4. With AVX-512 twice the value costs up to 9 % (AMD
// Zen 4, `sweepstake-lab bench`).
constexpr uint64_t kChecksPerLayout = 256;
// If a search takes more checks than expected from its numbers of boxes and pairs, another layout
// is tried every kFramesPerTrial frames. A new layout helps if the scene has spread since the last
// one, but not if the scene is just dense.
constexpr uint64_t kExpectedChecksPerBox = 128;
constexpr uint64_t kExpectedChecksPerPair = 16;
constexpr uint32_t kFramesPerTrial = 64;
// If more boxes than kLongAllowance + n / kBoxesPerLong (n: the number of boxes) are too long for
// their cells, the grids are laid out again.
constexpr size_t kBoxesPerLong = 64;
constexpr size_t kLongAllowance = 16;
// The scene counts as nearly at rest if fewer than 1 in 128 boxes change their lists in a frame.
constexpr size_t kBoxesPerCrossing = 128;
// A margin is the shortest side of the cells (narrowest_cell) divided by this. It is wide enough to
// hold slow boxes for many frames, and narrow enough to add few pairs.
constexpr float kMarginsPerCell = 48;
// Margins are tried only in scenes with at most this number of pairs per box. With more, testing
// the kept pairs in each frame costs as much as finding them.
constexpr size_t kMaxPairsPerBox = 8;
// Margins save time if the boxes stay within them for at least this number of frames. Otherwise
// they are tried again after a wait. The wait doubles each time, up to kMaxWaitFrames.
constexpr uint32_t kMinRestFrames = 6;
constexpr uint32_t kMaxWaitFrames = 256;
// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinSearchedPerPart = 1024;

class Tracy final : public BroadPhase {
 public:
  explicit Tracy(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "Tracy"; }
  uint32_t version() const override { return 6; }
  void DoBuild(std::span<const Aabb> boxes) override;
  void DoUpdate(std::span<const Aabb> boxes) override;
  void DoFindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return plan_.native_bytes() + lists_.native_bytes() + rest_.native_bytes() +
           parts_.native_bytes();
  }

 private:
  void LayOut(std::span<const Aabb> boxes);
  bool UpdateAtRest(const GridBoxes& boxes);
  bool StartResting(const GridBoxes& boxes);
  void WaitBeforeRest();
  void UpdateInMotion(const GridBoxes& boxes);

  Executor* executor_;
  GridPlan plan_;
  TracyLists lists_;
  PairParts parts_;
  TracyRest rest_;
  bool resting_ = false;
  uint32_t rest_frames_ = 0;  // frames since the margins were last set
  uint32_t wait_ = 0;         // frames until margins are tried again
  uint32_t last_wait_ = 1;
  size_t pair_count_ = 0;     // the number of pairs of the latest search
  uint32_t frames_ = 0;       // the frames since the grids were laid out
  bool inefficient_ = false;  // whether the latest grid search took more checks than expected
  RebuildDebt debt_;          // extra checks since the grids were laid out
  uint64_t checks_ = 0;
};

void Tracy::DoBuild(std::span<const Aabb> boxes) {
  wait_ = 0;
  last_wait_ = 1;
  pair_count_ = 0;
  LayOut(boxes);
}

void Tracy::LayOut(std::span<const Aabb> boxes) {
  checks_ = 0;
  plan_.Reset();
  const GridBoxes in_grids = plan_.MakeGrids(executor_, boxes, stop());
  if (IsStopped(stop())) return;
  lists_.Reset(RowGrids(plan_));
  lists_.Update(executor_, in_grids, 0, stop());
  debt_.Clear();
  frames_ = 0;
  inefficient_ = false;
  resting_ = false;
}

void Tracy::DoUpdate(std::span<const Aabb> all) {
  checks_ = 0;
  const GridBoxes boxes = plan_.InGrids(executor_, all, stop());
  if (resting_ && UpdateAtRest(boxes)) return;
  const bool may_rest = wait_ == 0 && pair_count_ < kMaxPairsPerBox * boxes.size() &&
                        lists_.moved_count() * kBoxesPerCrossing < boxes.size();
  if (!may_rest || !StartResting(boxes)) UpdateInMotion(boxes);
}

// Updates `rest_` from the boxes of this frame. If that fails (TracyRest::Step) and the margins
// have held for kMinRestFrames frames, sets new margins. If they have held for fewer frames,
// returns false: the lists then need an Update without margins.
bool Tracy::UpdateAtRest(const GridBoxes& boxes) {
  ++rest_frames_;
  if (rest_.Step(executor_, boxes, lists_, checks_, stop())) return true;
  resting_ = false;
  if (rest_frames_ >= kMinRestFrames) {
    last_wait_ = 1;
    return StartResting(boxes);
  }
  WaitBeforeRest();
  return false;
}

// Sets margins. If they add too many pairs, returns false: the lists then need an Update without
// margins.
bool Tracy::StartResting(const GridBoxes& boxes) {
  const float margin = lists_.narrowest_cell() / kMarginsPerCell;
  lists_.SetMargin(margin);
  resting_ = rest_.Start(executor_, boxes, margin, lists_, checks_, stop());
  rest_frames_ = 0;
  if (!resting_) WaitBeforeRest();
  return resting_;
}

void Tracy::WaitBeforeRest() {
  last_wait_ = std::min(2 * last_wait_, kMaxWaitFrames);
  wait_ = last_wait_;
  lists_.SetMargin(0);
}

void Tracy::UpdateInMotion(const GridBoxes& boxes) {
  ++frames_;
  if (wait_ > 0) --wait_;
  const bool try_another = inefficient_ && frames_ >= kFramesPerTrial;
  if (try_another || debt_.Exceeds(kChecksPerLayout * boxes.size())) return LayOut(boxes.boxes);
  lists_.Update(executor_, boxes, 0, stop());
  if (IsStopped(stop())) return;
  if (lists_.long_count() > boxes.size() / kBoxesPerLong + kLongAllowance) LayOut(boxes.boxes);
}

void Tracy::DoFindPairs(PairBuffer& out) {
  if (resting_) return rest_.Append(out);
  const GridView view = lists_.View();
  const size_t before = out.size();
  checks_ = parts_.Run(
      executor_, lists_.size(), kMinSearchedPerPart, GridView::kBatch, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        return SearchGrids(view, begin, end, pairs, stop());
      },
      stop());
  debt_.AddSearch(checks_);
  pair_count_ = out.size() - before;
  inefficient_ =
      checks_ > kExpectedChecksPerBox * lists_.size() + kExpectedChecksPerPair * pair_count_;
}

}  // namespace

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options) {
  return std::make_unique<Tracy>(options);
}

}  // namespace sweepstake
