// The interface's functions and the only list of all backends. Add a line here for a new backend.
#include <algorithm>
#include <array>
#include <utility>

#include "engine_client/broad_phase/brute_force.h"
#include "engine_client/broad_phase/common/pair_limit.h"
#include "engine_client/broad_phase/dbvt/dbvt.h"
#include "engine_client/broad_phase/grid/grid.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/broad_phase/kd/kd_tree.h"
#include "engine_client/broad_phase/sweep/axis_sweep.h"
#include "engine_client/broad_phase/sweep/sap.h"
#include "engine_client/broad_phase/tracy/tracy.h"
#include "engine_client/text/names.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/simd.h"

namespace sweepstake {
namespace {

struct Family {
  std::string_view name;
  std::unique_ptr<BroadPhase> (*make)(const BroadPhaseOptions&);
};

// The order is that of Table 1 in the paper that README.md names.
constexpr std::array kFamilies = {
    Family{"BruteForce", MakeBruteForce}, Family{"Grid", MakeGrid}, Family{"SAP", MakeSap},
    Family{"AxisSweep", MakeAxisSweep},   Family{"DBVT", MakeDbvt}, Family{"Tracy", MakeTracy},
    Family{"KDTree", MakeKdTree},
};

// A backend starts again if more than 1 in 8 boxes have gone. Without that, Tracy's frames took 1.4
// times as long for 160 frames after 1 in 5 had gone; after 1 in 9 had gone, no frame took longer
// (2,000 boxes, AMD Zen 5).
constexpr uint32_t kBoxesPerGone = 8;
// The minimum number of frames between two starts. A start costs one to three frames, so that a
// number of boxes that rises and falls all the time costs a tenth more at most.
constexpr uint8_t kFramesPerStart = 32;

constexpr auto kNames = [] {
  std::array<std::string_view, kFamilies.size()> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kFamilies[i].name;
  return names;
}();

}  // namespace

// Replaces the stop request during a call, also if the call throws.
class BroadPhase::StopScope {
 public:
  StopScope(BroadPhase& backend, StopRequest& stop)
      : backend_(backend), before_(std::exchange(backend.stop_, &stop)) {}
  ~StopScope() { backend_.stop_ = before_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  BroadPhase& backend_;
  StopRequest* const before_;
};

void BroadPhase::Build(std::span<const Aabb> boxes) {
  const FloatEnvironmentScope scope;
  Start(boxes);
}

void BroadPhase::Update(std::span<const Aabb> boxes) {
  const FloatEnvironmentScope scope;
  Advance(boxes);
}

void BroadPhase::FindPairs(PairBuffer& out) {
  const FloatEnvironmentScope scope;
  Search(out);
}

void BroadPhase::Start(std::span<const Aabb> boxes) {
  frames_to_start_ = kFramesPerStart;
  peak_count_ = static_cast<uint32_t>(boxes.size());
  DoBuild(boxes);
}

// Starts again after many boxes have gone. Backends keep decisions and estimates that were made for
// those boxes: grids, the cost of a sweep, waits before margins are tried again.
void BroadPhase::Advance(std::span<const Aabb> boxes) {
  peak_count_ = std::max(peak_count_, static_cast<uint32_t>(boxes.size()));
  if (frames_to_start_ > 0) --frames_to_start_;
  const bool are_many_gone = boxes.size() < peak_count_ - peak_count_ / kBoxesPerGone;
  if (frames_to_start_ == 0 && are_many_gone) return Start(boxes);
  DoUpdate(boxes);
}

void BroadPhase::Search(PairBuffer& out) {
  pairs_exceeded_ = false;
  if (max_pairs_ == 0) return DoFindPairs(out);
  const size_t before = out.size();
  PairLimit limit(stop_, max_pairs_);
  {
    const StopScope stop(*this, limit);
    DoFindPairs(out);
  }
  // Kept pairs, which some backends copy, do not pass through the limit.
  pairs_exceeded_ = limit.is_exceeded() || out.size() - before > max_pairs_;
  if (pairs_exceeded_) out.Truncate(before);
}

std::span<const std::string_view> BroadPhaseNames() { return kNames; }

Result<std::unique_ptr<BroadPhase>> MakeBroadPhase(std::string_view name,
                                                   const BroadPhaseOptions& options) {
  if (Status simd = UseSimdTargetOfEnvironment(); !simd.ok()) return simd;
  for (const Family& family : kFamilies) {
    if (family.name != name) continue;
    std::unique_ptr<BroadPhase> made = family.make(options);
    made->max_pairs_ = options.max_pairs;
    return made;
  }
  return Status(StatusCode::kNotFound, text::UnknownName("broad phase", name, kNames));
}

}  // namespace sweepstake
