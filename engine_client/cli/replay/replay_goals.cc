#include "engine_client/cli/replay/replay_goals.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

namespace sweepstake::cli {
namespace {

using Figure = std::function<std::optional<double>(const JudgedCell&)>;

bool Meets(const ReplayGoal& goal, double value) {
  if (value == goal.limit) return !goal.exclusive;
  return (value > goal.limit) == goal.at_least;
}

// Judges every cell of which `figure` is there; the worst one speaks for the goal.
ReplayGoal Each(ReplayGoal goal, std::span<const JudgedCell> cells, const Figure& figure) {
  for (const JudgedCell& cell : cells) {
    const std::optional<double> value = figure(cell);
    if (value) goal.cells.push_back({cell.cell.name(), *value, Meets(goal, *value)});
  }
  std::stable_sort(goal.cells.begin(), goal.cells.end(),
                   [&](const ReplayGoal::Cell& a, const ReplayGoal::Cell& b) {
                     return goal.at_least ? a.value < b.value : a.value > b.value;
                   });
  if (goal.cells.empty()) return goal;
  goal.reached = goal.cells.front().value;
  goal.met = Meets(goal, *goal.reached);
  return goal;
}

// `figure` in the cells of a category.
Figure In(CellCategory category, double StudyRow::*figure, const StudyRow* JudgedCell::*row) {
  return [=](const JudgedCell& cell) -> std::optional<double> {
    if (cell.cell.category != category) return std::nullopt;
    return (cell.*row)->*figure;
  };
}

std::optional<double> RegretWhereHeadroom(const JudgedCell& cell) {
  const bool judged =
      cell.cell.category == CellCategory::kChanging && cell.cold->headroom >= kJudgedHeadroom;
  return judged ? std::optional(cell.cold->regret_best_fixed) : std::nullopt;
}

std::optional<double> CapturedWhereHeadroom(const JudgedCell& cell) {
  return RegretWhereHeadroom(cell) ? cell.cold->headroom_captured : std::nullopt;
}

std::optional<double> WrongPrior(const JudgedCell& cell) { return cell.wrong->regret_best_fixed; }

std::optional<double> BailOuts(const JudgedCell& cell) {
  return cell.cold->bail_outs.value_or(0) + cell.right->bail_outs.value_or(0) +
         cell.wrong->bail_outs.value_or(0);
}

ReplayGoal AgainstPaper(ReplayGoal goal, std::span<const JudgedCell> cells) {
  double own = 0;
  double paper = 0;
  size_t count = 0;
  for (const JudgedCell& cell : cells) {
    if (cell.cell.category != CellCategory::kStationary) continue;
    own += cell.cold->regret_best_fixed;
    paper += cell.paper->regret_best_fixed;
    ++count;
  }
  if (count == 0) return goal;
  goal.reached = own > 0 ? paper / own : std::numeric_limits<double>::infinity();
  goal.met = Meets(goal, *goal.reached);
  return goal;
}

}  // namespace

std::vector<ReplayGoal> JudgeGoals(std::span<const JudgedCell> cells, double decision_p99_ms) {
  constexpr auto kStationary = CellCategory::kStationary;
  constexpr auto kRegret = &StudyRow::regret_best_fixed;
  std::vector<ReplayGoal> goals;
  goals.push_back(Each({.name = "stationary, after start-up", .limit = 0.01}, cells,
                       In(kStationary, &StudyRow::regret_after_start_up, &JudgedCell::cold)));
  goals.push_back(Each({.name = "stationary, with the cold start", .limit = 0.025}, cells,
                       In(kStationary, kRegret, &JudgedCell::cold)));
  goals.push_back(Each({.name = "stationary, with a same-class prior", .limit = 0.01}, cells,
                       In(kStationary, kRegret, &JudgedCell::right)));
  goals.push_back(
      Each({.name = "changing: better than the best fixed arm", .limit = 0, .exclusive = true},
           cells, RegretWhereHeadroom));
  goals.push_back(
      Each({.name = "changing: share of the oracle's headroom", .limit = 0.5, .at_least = true},
           cells, CapturedWhereHeadroom));
  goals.push_back(Each({.name = "regimes up to the cooldown", .limit = 0.04}, cells,
                       In(CellCategory::kResonant, kRegret, &JudgedCell::cold)));
  goals.push_back(Each({.name = "wrong prior", .limit = 0.04}, cells, WrongPrior));
  goals.push_back(
      Each({.name = "bail-outs with the shadow lane", .unit = GoalUnit::kCount, .limit = 0}, cells,
           BailOuts));
  goals.push_back(AgainstPaper({.name = "stationary regret of paper against it",
                                .unit = GoalUnit::kTimes,
                                .limit = 10,
                                .at_least = true},
                               cells));
  ReplayGoal latency{.name = "a decision, p99 with 32 arms",
                     .unit = GoalUnit::kMilliseconds,
                     .limit = 1,
                     .exclusive = true,
                     .reached = decision_p99_ms};
  latency.met = Meets(latency, decision_p99_ms);
  goals.push_back(std::move(latency));
  return goals;
}

}  // namespace sweepstake::cli
