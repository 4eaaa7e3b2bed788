#include "engine_client/cli/bench/bench_goals.h"

#include <algorithm>

namespace sweepstake::cli {
namespace {

struct FamilyGoal {
  std::string_view family;
  double moving;   // in the reference suite
  double resting;  // where hardly anything moves; 0: no goal
};

// Brute force, grid, SAP and the trees have to be better than the same idea elsewhere; the
// incremental ones have to stay ahead where being incremental is the point, too.
constexpr FamilyGoal kFamilyGoals[] = {
    {"BruteForce", 3, 0}, {"Grid", 6, 0},   {"SAP", 3, 0},    {"AxisSweep", 10, 1.3},
    {"DBVT", 7, 1.3},     {"Tracy", 20, 0}, {"KDTree", 8, 0},
};
constexpr double kTracyAgainstMbp = 4;

bool IsSuite(const BenchCell& cell) { return cell.scene.starts_with("suite-"); }

bool IsResting(const BenchCell& cell) {
  return cell.scene == "nearly-resting" || cell.scene == "few-moving";
}

std::optional<double> GoalOfFamily(const BenchRatio& ratio, const BenchCell& cell) {
  if (ratio.other == "PhysxMbp") return kTracyAgainstMbp;
  const auto goal =
      std::find_if(std::begin(kFamilyGoals), std::end(kFamilyGoals),
                   [&](const FamilyGoal& each) { return each.family == ratio.family; });
  if (goal == std::end(kFamilyGoals)) return std::nullopt;
  if (IsSuite(cell)) return goal->moving;
  if (IsResting(cell) && goal->resting > 0) return goal->resting;
  return std::nullopt;
}

std::optional<double> GoalOfBest(const BenchCell& cell) {
  constexpr double kSmall = 5;
  constexpr double kLargeOrClustered = 10;
  constexpr double kOtherShapes = 3;
  if (IsResting(cell)) return std::nullopt;
  if (!IsSuite(cell)) return kOtherShapes;
  return cell.object_count >= 100'000 || cell.scene == "suite-g" ? kLargeOrClustered : kSmall;
}

}  // namespace

std::optional<double> GoalOf(const BenchRatio& ratio, const BenchCell& cell) {
  switch (ratio.kind) {
    case RatioKind::kFamily:
      return GoalOfFamily(ratio, cell);
    case RatioKind::kOverall:
      return GoalOfBest(cell);
    case RatioKind::kGrowth:
      return 2;
    case RatioKind::kThreads:
      return IsSuite(cell) && cell.object_count >= 10'000 && ratio.thread_count == 2
                 ? std::optional(1.7)
                 : std::nullopt;
    case RatioKind::kSpike:
      return 2;
    case RatioKind::kMemory:
      return 1;
  }
  return std::nullopt;
}

bool MeetsGoal(const BenchRatio& ratio) {
  if (!ratio.goal) return true;
  const bool large_is_good = ratio.kind == RatioKind::kFamily ||
                             ratio.kind == RatioKind::kOverall || ratio.kind == RatioKind::kThreads;
  return large_is_good ? ratio.value >= *ratio.goal : ratio.value <= *ratio.goal;
}

}  // namespace sweepstake::cli
