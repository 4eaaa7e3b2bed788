#include "engine_client/cli/replay/replay_goals_output.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/replay/replay_output.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string Figure(GoalUnit unit, double value) {
  switch (unit) {
    case GoalUnit::kPercent:
      return Percent(value);
    case GoalUnit::kTimes:
      return std::isinf(value) ? "none left" : Fixed(value, 1) + "x";
    case GoalUnit::kCount:
      return Fixed(value, 2);
    case GoalUnit::kMilliseconds:
      return Fixed(value, 3) + " ms";
  }
  return "";
}

std::string LimitText(const ReplayGoal& goal) {
  const std::string word = goal.at_least ? "at least " : goal.exclusive ? "below " : "at most ";
  return word + Figure(goal.unit, goal.limit);
}

std::string CellsText(const ReplayGoal& goal) {
  if (goal.cells.empty()) return "-";
  size_t met = 0;
  for (const ReplayGoal::Cell& cell : goal.cells) met += cell.met ? 1 : 0;
  return std::to_string(met) + " of " + std::to_string(goal.cells.size()) + ", worst " +
         goal.cells.front().name;
}

std::string ResultText(const ReplayGoal& goal) {
  if (!goal.reached) return "nothing to judge";
  return goal.met ? "met" : "NOT MET";
}

void PrintGoals(std::span<const ReplayGoal> goals, std::ostream& out) {
  TextTable table({"goal", "limit", "reached", "cells", "result"});
  for (const ReplayGoal& goal : goals) {
    table.AddRow({goal.name, LimitText(goal), goal.reached ? Figure(goal.unit, *goal.reached) : "-",
                  CellsText(goal), ResultText(goal)});
  }
  table.Print(out);
}

void PrintCells(const ReplayJudgement& judgement, std::ostream& out) {
  TextTable table({"cell", "category", "floor", "headroom", "regret", "ci95", "after_start",
                   "prior", "wrong_prior", "captured", "switches", "share", "bail_outs", "paper"});
  for (const JudgedCell& judged : judgement.judged()) {
    const StudyRow& row = *judged.cold;
    const double floor = judgement.scenes[row.scene].scene.control_regret();
    table.AddRow({judged.cell.name(), std::string(CategoryName(judged.cell.category)),
                  Percent(std::abs(floor)), Percent(row.headroom), Percent(row.regret_best_fixed),
                  Percent(row.ci95.low) + " to " + Percent(row.ci95.high),
                  Percent(row.regret_after_start_up), Percent(judged.right->regret_best_fixed),
                  Percent(judged.wrong->regret_best_fixed),
                  row.headroom_captured ? Fixed(100 * *row.headroom_captured, 0) + "%" : "-",
                  Fixed(row.switches, 1), Fixed(row.active_share, 2),
                  row.bail_outs ? Fixed(*row.bail_outs, 2) : "-",
                  Percent(judged.paper->regret_best_fixed)});
  }
  table.Print(out);
}

void PrintCategories(const ReplayJudgement& judgement, std::ostream& out) {
  TextTable table(
      {"policy", "category", "cells", "regret", "worst", "after_start", "switches", "bail_outs"});
  for (const CategoryRow& row : ByCategory(judgement)) {
    table.AddRow(
        {judgement.options.players[row.player].name, std::string(CategoryName(row.category)),
         std::to_string(row.cell_count), Percent(row.regret), Percent(row.worst_regret),
         Percent(row.regret_after_start_up), Fixed(row.switches, 1), Fixed(row.bail_outs, 2)});
  }
  table.Print(out);
}

Json GoalJson(const ReplayGoal& goal) {
  Json json = {{"goal", goal.name},  {"limit", goal.limit}, {"limit_text", LimitText(goal)},
               {"reached", nullptr}, {"met", goal.met},     {"cells", Json::array()}};
  if (goal.reached) json["reached"] = *goal.reached;
  for (const ReplayGoal::Cell& cell : goal.cells) {
    json["cells"].push_back({{"cell", cell.name}, {"value", cell.value}, {"met", cell.met}});
  }
  return json;
}

Json CellJson(const ReplayJudgement& judgement, const JudgedCell& judged) {
  return {{"cell", judged.cell.name()},
          {"category", CategoryName(judged.cell.category)},
          {"pass_ns", judged.cell.pass_ns},
          {"control_regret", judgement.scenes[judged.cold->scene].scene.control_regret()},
          {"regret_right_prior", judged.right->regret_best_fixed},
          {"regret_wrong_prior", judged.wrong->regret_best_fixed}};
}

}  // namespace

void PrintGoalsTable(const ReplayJudgement& judgement, std::span<const ReplayGoal> goals,
                     std::ostream& out) {
  out << "Policy " << judgement.options.players.front().name << ", " << judgement.options.seed_count
      << " seeds in each of " << judgement.cells.size()
      << " cells; regret is frame time against the best fixed arm's.\n\n";
  PrintGoals(goals, out);
  out << '\n';
  PrintCells(judgement, out);
  out << "\nfloor: the same arm measured twice. headroom: of the best sequence of arms that pays "
         "for\nits switches; captured: how much of it was reached. prior: with what another seed's "
         "game\nhad learnt.\n\n";
  PrintCategories(judgement, out);
}

void PrintGoalsJson(const ReplayJudgement& judgement, std::span<const ReplayGoal> goals,
                    std::ostream& out) {
  Json document = {{"command", "replay"},
                   {"policy", judgement.options.players.front().name},
                   {"seeds", judgement.options.seed_count},
                   {"goals", Json::array()},
                   {"cells", Json::array()},
                   {"rows", RowsJson({judgement.scenes, judgement.options, judgement.cold})}};
  for (const ReplayGoal& goal : goals) document["goals"].push_back(GoalJson(goal));
  for (const JudgedCell& cell : judgement.judged()) {
    document["cells"].push_back(CellJson(judgement, cell));
  }
  PrintJson(document, out);
}

}  // namespace sweepstake::cli
