#include "engine_client/broad_phase/grid/grid.h"

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/grid/grid_search.h"
#include "engine_client/broad_phase/grid/grid_sort.h"

namespace sweepstake {
namespace {

// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinSearchedPerPart = 1024;

class Grid final : public BroadPhase {
 public:
  explicit Grid(const BroadPhaseOptions& options) : executor_(options.executor) {}
  std::string_view name() const override { return "Grid"; }
  uint32_t version() const override { return 6; }
  void DoBuild(std::span<const Aabb> boxes) override {
    plan_.Reset();
    DoUpdate(boxes);
  }
  void DoUpdate(std::span<const Aabb> boxes) override {
    checks_ = 0;
    count_ = boxes.size();
    const GridBoxes both = plan_.MakeGrids(executor_, boxes, stop());
    if (IsStopped(stop())) return;
    sort_.Sort(executor_, both, plan_.grids(), plan_.choice(), stop());
  }
  void DoFindPairs(PairBuffer& out) override {
    const GridView view{sort_.columns().lanes(), sort_.columns().in_grids(), sort_.starts(),
                        plan_.grids(), plan_.searches()};
    checks_ = parts_.Run(
        executor_, count_, kMinSearchedPerPart, GridView::kBatch, out,
        [&](size_t begin, size_t end, PairBuffer& pairs) {
          return SearchGrids(view, begin, end, pairs, stop());
        },
        stop());
  }
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override {
    return plan_.native_bytes() + sort_.native_bytes() + parts_.native_bytes();
  }

 private:
  Executor* executor_;
  GridPlan plan_;
  GridSort sort_;
  PairParts parts_;
  size_t count_ = 0;
  uint64_t checks_ = 0;
};

}  // namespace

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options) {
  return std::make_unique<Grid>(options);
}

}  // namespace sweepstake
