#include "engine_client/cli/replay/replay_judgement.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine_client/cli/replay/replay_decision_time.h"

namespace sweepstake::cli {
namespace {

size_t PaperOf(const StudyOptions& options) {
  const auto paper =
      std::find_if(options.players.begin(), options.players.end(),
                   [](const ReplayPlayer& player) { return player.name == "paper"; });
  return static_cast<size_t>(paper - options.players.begin());
}

CategoryRow RowOf(const ReplayJudgement& judgement, uint32_t player, CellCategory category) {
  CategoryRow row{.player = player,
                  .category = category,
                  .worst_regret = -std::numeric_limits<double>::infinity()};
  for (const StudyRow& each : judgement.cold) {
    if (each.player != player || judgement.cells[each.scene].category != category) continue;
    ++row.cell_count;
    row.regret += each.regret_best_fixed;
    row.regret_after_start_up += each.regret_after_start_up;
    row.worst_regret = std::max(row.worst_regret, each.regret_best_fixed);
    row.switches += each.switches;
    row.bail_outs += each.bail_outs.value_or(0);
  }
  const double share = 1.0 / static_cast<double>(std::max<size_t>(row.cell_count, 1));
  for (double* mean : {&row.regret, &row.regret_after_start_up, &row.switches, &row.bail_outs}) {
    *mean *= share;
  }
  return row;
}

}  // namespace

std::vector<JudgedCell> ReplayJudgement::judged() const {
  const size_t player_count = options.players.size();
  const size_t paper = PaperOf(options);
  std::vector<JudgedCell> judged;
  for (size_t i = 0; i < cells.size(); ++i) {
    judged.push_back({.cell = cells[i],
                      .cold = &cold[i * player_count],
                      .right = &right[i],
                      .wrong = &wrong[i],
                      .paper = &cold[i * player_count + paper]});
  }
  return judged;
}

ReplayJudgement JudgePolicy(std::vector<ReplayCell> cells, std::vector<StudyScene> scenes,
                            const StudyOptions& options,
                            const std::function<void(uint64_t, uint64_t)>& on_game) {
  ReplayJudgement judgement;
  judgement.cells = std::move(cells);
  judgement.scenes = std::move(scenes);
  judgement.options = options;
  const uint64_t per_player = judgement.scenes.size() * uint64_t{options.seed_count};
  const uint64_t all = per_player * (options.players.size() + 2);
  uint64_t before = 0;
  const auto run = [&](const StudyOptions& study) {
    auto rows = RunStudy(judgement.scenes, study,
                         [&](uint64_t done, uint64_t) { on_game(before + done, all); });
    before += per_player * study.players.size();
    return rows;
  };
  judgement.cold = run(options);
  StudyOptions with_priors = options;
  with_priors.players.resize(1);
  with_priors.priors = ReplayPriors::kRight;
  judgement.right = run(with_priors);
  with_priors.priors = ReplayPriors::kWrong;
  judgement.wrong = run(with_priors);
  judgement.decision_p99_ms = DecisionP99Ms(options.players.front().name, decision::kMaxArms);
  return judgement;
}

std::vector<CategoryRow> ByCategory(const ReplayJudgement& judgement) {
  std::vector<CategoryRow> rows;
  for (uint32_t player = 0; player < judgement.options.players.size(); ++player) {
    for (const CellCategory category :
         {CellCategory::kStationary, CellCategory::kChanging, CellCategory::kResonant}) {
      const CategoryRow row = RowOf(judgement, player, category);
      if (row.cell_count > 0) rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace sweepstake::cli
