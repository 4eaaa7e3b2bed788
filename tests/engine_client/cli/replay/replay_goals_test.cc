// The list of scenes and the goals that are judged on them.
#include "engine_client/cli/replay/replay_goals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "engine_client/cli/replay/replay_cells.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

Result<std::vector<ReplayCell>> Parsed(const std::string& text) {
  std::istringstream stream(text);
  return ParseCells(stream);
}

TEST(ParseCells, ReadsALineEachAndLeavesCommentsOut) {
  const auto cells = Parsed(
      "# scene objects frames seed pass category\n"
      "\n"
      "brownian  1000 3000 101 15m stationary   # the paper's\n"
      "waves     3000 3600 202 90s resonant\n");
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 2U);
  EXPECT_EQ((*cells)[0].name(), "brownian-1000-101");
  EXPECT_EQ((*cells)[0].category, CellCategory::kStationary);
  EXPECT_EQ((*cells)[1].frame_count, 3600U);
  EXPECT_EQ((*cells)[1].pass_ns, 90'000'000'000U);
  EXPECT_EQ((*cells)[1].category, CellCategory::kResonant);
}

TEST(ParseCells, NamesTheLineThatIsNone) {
  const auto message = [](const std::string& text) { return Parsed(text).status().message(); };
  EXPECT_THAT(message("\nbrownian 1000 3000 1 15m"), HasSubstr("line 2 has 5 words"));
  EXPECT_THAT(message("brownian many 3000 1 15m stationary"), HasSubstr("objects"));
  EXPECT_THAT(message("brownian 1000 3000 1 15 stationary"), HasSubstr("'15' is no duration"));
  EXPECT_THAT(message("brownian 1000 3000 1 15m calm"), HasSubstr("changing, resonant"));
  EXPECT_THAT(message("# nothing\n"), HasSubstr("no scene"));
}

// The rows of a policy that reaches every goal, and of `paper`, in one cell.
struct CellRows {
  ReplayCell cell;
  StudyRow cold;
  StudyRow right;
  StudyRow wrong;
  StudyRow paper;

  JudgedCell judged() const { return {cell, &cold, &right, &wrong, &paper}; }
};

CellRows Rows(CellCategory category) {
  CellRows rows;
  rows.cell = {"scene", 1000, 3000, 1, 900'000'000'000, category};
  rows.cold.regret_best_fixed = category == CellCategory::kChanging ? -0.08 : 0.01;
  rows.cold.regret_after_start_up = 0.005;
  rows.cold.headroom = 0.1;
  rows.cold.headroom_captured = 0.8;
  rows.cold.bail_outs = 0;
  rows.right.regret_best_fixed = 0.005;
  rows.wrong.regret_best_fixed = 0.03;
  rows.paper.regret_best_fixed = 0.2;
  return rows;
}

std::vector<std::string> Missed(const CellRows& rows, double decision_p99_ms = 0.2) {
  const JudgedCell cells[] = {rows.judged()};
  std::vector<std::string> missed;
  for (const ReplayGoal& goal : JudgeGoals(cells, decision_p99_ms)) {
    if (goal.reached && !goal.met) missed.push_back(goal.name);
  }
  return missed;
}

TEST(JudgeGoals, APolicyThatReachesEveryLimitMissesNone) {
  for (const auto category :
       {CellCategory::kStationary, CellCategory::kChanging, CellCategory::kResonant}) {
    EXPECT_TRUE(Missed(Rows(category)).empty());
  }
}

TEST(JudgeGoals, EachGoalIsMissedByItsOwnFigure) {
  const auto missed = [](CellCategory category, const std::function<void(CellRows&)>& change) {
    CellRows rows = Rows(category);
    change(rows);
    const std::vector<std::string> names = Missed(rows);
    return names.size() == 1 ? names[0] : std::to_string(names.size()) + " goals";
  };
  using enum CellCategory;
  EXPECT_EQ(missed(kStationary, [](CellRows& r) { r.cold.regret_after_start_up = 0.0101; }),
            "stationary, after start-up");
  EXPECT_EQ(missed(kStationary,
                   [](CellRows& r) {
                     r.cold.regret_best_fixed = 0.0251;
                     r.paper.regret_best_fixed = 0.5;
                   }),
            "stationary, with the cold start");
  EXPECT_EQ(missed(kStationary, [](CellRows& r) { r.right.regret_best_fixed = 0.0101; }),
            "stationary, with a same-class prior");
  EXPECT_EQ(missed(kChanging, [](CellRows& r) { r.cold.regret_best_fixed = 0; }),
            "changing: better than the best fixed arm");
  EXPECT_EQ(missed(kChanging, [](CellRows& r) { r.cold.headroom_captured = 0.49; }),
            "changing: share of the oracle's headroom");
  EXPECT_EQ(missed(kResonant, [](CellRows& r) { r.cold.regret_best_fixed = 0.041; }),
            "regimes up to the cooldown");
  EXPECT_EQ(missed(kStationary, [](CellRows& r) { r.wrong.regret_best_fixed = 0.041; }),
            "wrong prior");
  EXPECT_EQ(missed(kResonant, [](CellRows& r) { r.wrong.bail_outs = 0.1; }),
            "bail-outs with the shadow lane");
  EXPECT_EQ(missed(kStationary, [](CellRows& r) { r.paper.regret_best_fixed = 0.09; }),
            "stationary regret of paper against it");
  EXPECT_EQ(Missed(Rows(kResonant), 1.0), std::vector<std::string>{"a decision, p99 with 32 arms"});
}

TEST(JudgeGoals, ChangingScenesWithoutHeadroomAreNotJudged) {
  CellRows rows = Rows(CellCategory::kChanging);
  rows.cold.headroom = 0.04;
  rows.cold.regret_best_fixed = 0.02;
  EXPECT_TRUE(Missed(rows).empty());
}

TEST(JudgeGoals, TheWorstCellSpeaksForAGoalAndComesFirst) {
  CellRows good = Rows(CellCategory::kStationary);
  CellRows bad = Rows(CellCategory::kStationary);
  bad.cell.scene = "bad";
  bad.cold.regret_after_start_up = 0.02;
  const JudgedCell cells[] = {good.judged(), bad.judged()};
  const ReplayGoal goal = JudgeGoals(cells, 0.2)[0];
  EXPECT_EQ(goal.reached, 0.02);
  ASSERT_EQ(goal.cells.size(), 2U);
  EXPECT_EQ(goal.cells[0].name, "bad-1000-1");
  EXPECT_FALSE(goal.cells[0].met);
  EXPECT_TRUE(goal.cells[1].met);
}

}  // namespace
}  // namespace sweepstake::cli
