// The goals of the policy of AI Decides, and whether replayed scenes reach them.
//
// Pure; safe from any thread. Ratios: 0.01 is one percent.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/replay/replay_cells.h"
#include "engine_client/cli/replay/replay_study.h"

namespace sweepstake::cli {

// The policy under judgement on one cell.
struct JudgedCell {
  ReplayCell cell;
  const StudyRow* cold = nullptr;   // without priors
  const StudyRow* right = nullptr;  // with priors of the same class
  const StudyRow* wrong = nullptr;  // with priors whose ranking is reversed
  const StudyRow* paper = nullptr;  // policy `paper`, without priors
};

enum class GoalUnit { kPercent, kTimes, kCount, kMilliseconds };

struct ReplayGoal {
  std::string name;
  GoalUnit unit = GoalUnit::kPercent;
  double limit = 0;
  bool at_least = false;   // the limit is the least; else the most
  bool exclusive = false;  // the limit itself misses the goal
  // Of the worst cell, or of all together where no cells are listed; absent: nothing to judge.
  std::optional<double> reached{};
  bool met = false;
  struct Cell {
    std::string name;
    double value = 0;
    bool met = false;
  };
  std::vector<Cell> cells{};  // behind it, the worst first
};

// In the order of the table of goals. `decision_p99_ms`: of a decision with 32 arms.
std::vector<ReplayGoal> JudgeGoals(std::span<const JudgedCell> cells, double decision_p99_ms);

// Changing scenes with less are not judged.
inline constexpr double kJudgedHeadroom = 0.05;

}  // namespace sweepstake::cli
