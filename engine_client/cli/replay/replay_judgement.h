// Everything behind the table of goals: the judged policy on every cell of a list, with and without
// priors, beside the policies it is compared with.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/replay/replay_goals.h"
#include "engine_client/cli/replay/replay_study.h"

namespace sweepstake::cli {

struct ReplayJudgement {
  std::vector<ReplayCell> cells;
  std::vector<StudyScene> scenes;  // of the cells, in their order
  StudyOptions options;            // the first player is judged; `paper` is among them
  std::vector<StudyRow> cold;      // of all players
  std::vector<StudyRow> right;     // of the judged one
  std::vector<StudyRow> wrong;
  double decision_p99_ms = 0;

  // Borrows from this object.
  std::vector<JudgedCell> judged() const;
};

// REQUIRES: as many scenes as cells, with the same arms; options.players begins with the policy to
// judge and has `paper`.
ReplayJudgement JudgePolicy(std::vector<ReplayCell> cells, std::vector<StudyScene> scenes,
                            const StudyOptions& options,
                            const std::function<void(uint64_t done, uint64_t all)>& on_game);

// A player over all cells of a category: one row of the ablation table.
struct CategoryRow {
  uint32_t player = 0;
  CellCategory category = CellCategory::kStationary;
  size_t cell_count = 0;
  double regret = 0;  // means over the cells
  double regret_after_start_up = 0;
  double worst_regret = 0;
  double switches = 0;
  double bail_outs = 0;
};
// By player, then by category; categories without cells are left out.
std::vector<CategoryRow> ByCategory(const ReplayJudgement& judgement);

}  // namespace sweepstake::cli
