// The interface's functions and the only list of all backends. Add a line here for a new backend.
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
  DoBuild(boxes);
}

void BroadPhase::Update(std::span<const Aabb> boxes) {
  const FloatEnvironmentScope scope;
  DoUpdate(boxes);
}

void BroadPhase::FindPairs(PairBuffer& out) {
  const FloatEnvironmentScope scope;
  Search(out);
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
