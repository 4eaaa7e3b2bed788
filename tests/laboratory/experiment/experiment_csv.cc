// Writes the CSV files of an experiment.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/audit/cell_text.h"
#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/experiment/paper_tables.h"

namespace sweepstake::cli {
namespace {

std::string Number(double value) { return Fixed(value, 6); }
std::string Exact(double value) { return Fixed(value, 9); }

std::string ReasonText(uint32_t reason) {
  return reason == 0 ? "" : ReasonName(static_cast<SwitchReason>(reason));
}

// Returns "1" if the time is in the observation window, else "0".
std::string Observed(const RunRecord& record, double time_s) {
  return time_s >= record.exploration_s ? "1" : "0";
}

using RowWriter =
    std::function<void(const RunRecord& record, const std::string& run, CsvFile& csv)>;

Status WriteOne(std::span<const RunRecord> records, const std::filesystem::path& path,
                std::initializer_list<std::string_view> header, const RowWriter& write) {
  auto csv = CsvFile::Create(path, header);
  if (!csv.ok()) return csv.status();
  for (const RunRecord& record : records) write(record, RunLabel(record), **csv);
  return (*csv)->Commit();
}

void ActivationRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const ArmPeriod& each : ArmPeriods(record)) {
    csv.Row({run, record.arms[each.arm], Number(each.from_s), Number(each.to_s),
             ReasonText(each.reason), Observed(record, each.from_s)});
  }
}

void SwitchRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedSwitch& each : record.switches) {
    csv.Row({run, Number(each.time_s), std::to_string(each.frame), record.arms[each.from],
             record.arms[each.to], ReasonText(each.reason), Observed(record, each.time_s),
             std::to_string(each.rebuild_ns), std::to_string(each.settling_ns)});
  }
}

void DecisionRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedDecision& each : record.decisions) {
    const bool known = !each.best_probability.empty();
    csv.Row({run, Number(each.time_s), record.arms[each.active_arm],
             each.candidate < 0 ? "" : record.arms[static_cast<size_t>(each.candidate)],
             decision::NameOf(decision::kOutcomeNames, each.outcome), ReasonText(each.reason),
             each.reward < 0 ? "" : Exact(each.reward), known ? record.arms[each.leader] : "",
             known ? Exact(each.best_probability[each.leader]) : "",
             known ? Exact(each.expected_loss_ratio) : "",
             VerdictName(static_cast<Verdict>(each.verdict))});
  }
}

void PosteriorRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedDecision& each : record.decisions) {
    for (size_t arm = 0; arm < record.arms.size(); ++arm) {
      csv.Row({run, Number(each.time_s), record.arms[arm], Exact(each.alpha[arm]),
               Exact(each.beta[arm]),
               each.best_probability.empty() ? "" : Exact(each.best_probability[arm])});
    }
  }
}

void FinalRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  const PlayedRun summary = Summarize(record);
  for (size_t arm = 0; arm < record.arms.size(); ++arm) {
    const double alpha = record.decisions.empty() ? 1 : record.decisions.back().alpha[arm];
    const double beta = record.decisions.empty() ? 1 : record.decisions.back().beta[arm];
    const ArmControl& control = record.controls[arm];
    csv.Row({run, record.arms[arm], Exact(alpha), Exact(beta), Exact(alpha / (alpha + beta)),
             Exact(alpha + beta), Exact(summary.active_shares[arm]),
             arm == summary.dominant ? "1" : "0", std::to_string(record.observed[arm].frame_count),
             std::to_string(record.observed[arm].frame_ns),
             std::to_string(record.observed[arm].detection_ns), std::to_string(control.frame_count),
             Fixed(control.detection_ns_mean, 1)});
  }
}

void MetricRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const MetricWindow& each : record.windows) {
    csv.Row({run, Number(each.time_s), record.arms[each.arm], std::to_string(each.frame_count),
             Fixed(each.frame_us_mean, 3), Fixed(each.frame_us_max, 3),
             Fixed(each.detection_us_mean, 3), Fixed(each.check_count_mean, 1),
             Fixed(each.pair_count_mean, 1), std::to_string(each.native_bytes_max),
             std::to_string(each.object_count)});
  }
}

void TimeRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  const TimeShares& time = record.time;
  csv.Row({run, record.start_utc, Number(record.exploration_s), Number(record.end_s),
           std::to_string(time.scene_step_ns), std::to_string(time.detection_ns),
           std::to_string(time.rebuild_ns), std::to_string(time.copying_ns),
           std::to_string(time.around_ns), std::to_string(time.frame_end_ns),
           std::to_string(time.intake_ns), std::to_string(time.decision_ns),
           std::to_string(time.longest_decision_ns), std::to_string(time.lane_ns),
           std::to_string(record.shadow_visit_count), std::to_string(record.warm_switch_count),
           std::to_string(record.decisions.size()), std::to_string(record.dropped_frame_count)});
}

Status WriteRawCsv(std::span<const RunRecord> records, const std::filesystem::path& folder) {
  const struct {
    const char* name;
    std::initializer_list<std::string_view> header;
    RowWriter write;
  } files[] = {
      {"activations.csv", {"run", "arm", "from_s", "to_s", "reason", "observed"}, ActivationRows},
      {"switches.csv",
       {"run", "time_s", "frame", "from", "to", "reason", "observed", "rebuild_ns", "settling_ns"},
       SwitchRows},
      {"decisions.csv",
       {"run", "time_s", "active", "candidate", "outcome", "reason", "reward", "leader",
        "leader_best_probability", "expected_loss_ratio", "verdict"},
       DecisionRows},
      {"posteriors.csv",
       {"run", "time_s", "arm", "alpha", "beta", "best_probability"},
       PosteriorRows},
      {"final.csv",
       {"run", "arm", "alpha", "beta", "mu", "n", "active_share", "dominant", "observed_frames",
        "observed_frame_ns", "observed_detection_ns", "control_frames", "control_detection_ns"},
       FinalRows},
      {"metrics.csv",
       {"run", "time_s", "arm", "frames", "frame_us_mean", "frame_us_max", "detection_us_mean",
        "aabb_checks_mean", "pairs_mean", "native_bytes_max", "objects"},
       MetricRows},
      {"time.csv",
       {"run", "start_utc", "exploration_s", "end_s", "scene_step_ns", "detection_ns", "rebuild_ns",
        "copying_ns", "around_ns", "frame_end_ns", "intake_ns", "decision_ns",
        "longest_decision_ns", "lane_ns", "shadow_visits", "warm_switches", "decisions",
        "dropped_frames"},
       TimeRows},
  };
  for (const auto& file : files) {
    if (Status status = WriteOne(records, folder / file.name, file.header, file.write);
        !status.ok()) {
      return status;
    }
  }
  return {};
}

Status WriteTable3(std::span<const CellSummary> cells, const std::filesystem::path& path) {
  auto csv =
      CsvFile::Create(path, {"policy", "scene", "objects", "runs", "dominance", "interpretation",
                             "verdict", "paper_dominance", "paper_interpretation"});
  if (!csv.ok()) return csv.status();
  for (const CellSummary& cell : cells) {
    const PaperCell* paper = PaperOf(cell);
    (*csv)->Row({cell.policy, cell.cell.scene, std::to_string(cell.cell.object_count),
                 std::to_string(cell.runs.size()), cell.DominanceText(), cell.Interpretation(),
                 VerdictName(cell.verdict), paper == nullptr ? "" : paper->dominance,
                 paper == nullptr ? "" : paper->interpretation});
  }
  return (*csv)->Commit();
}

// Begins Table 4 with the names of Table4Row's columns.
Result<std::unique_ptr<CsvFile>> CreateTable4(const std::filesystem::path& path) {
  return CsvFile::Create(path, {"policy",
                                "scene",
                                "objects",
                                "runs",
                                "dominant",
                                "dominant_runs",
                                "switches_mean",
                                "switches_sd",
                                "active_percent_mean",
                                "active_percent_sd",
                                "mu_mean",
                                "mu_sd",
                                "n_mean",
                                "n_sd",
                                "paper_dominant",
                                "paper_dominant_runs",
                                "paper_switches_mean",
                                "paper_switches_sd",
                                "paper_active_percent_mean",
                                "paper_active_percent_sd",
                                "paper_mu_mean",
                                "paper_mu_sd",
                                "paper_n_mean",
                                "paper_n_sd"});
}

void Table4Row(const CellSummary& cell, CsvFile& csv) {
  const PaperCell* paper = PaperOf(cell);
  const auto printed = [&](double PaperFigure::*part, PaperFigure PaperCell::*figure) {
    return paper == nullptr ? std::string() : Fixed(paper->*figure.*part, 3);
  };
  const auto mean = [&](PaperFigure PaperCell::*figure) {
    return printed(&PaperFigure::mean, figure);
  };
  const auto deviation = [&](PaperFigure PaperCell::*figure) {
    return printed(&PaperFigure::deviation, figure);
  };
  csv.Row({cell.policy,
           cell.cell.scene,
           std::to_string(cell.cell.object_count),
           std::to_string(cell.runs.size()),
           cell.dominance.front().first,
           std::to_string(cell.dominance.front().second),
           Number(cell.switches.mean),
           Number(cell.switches.deviation),
           Number(cell.active_percent.mean),
           Number(cell.active_percent.deviation),
           Number(cell.posterior_mean.mean),
           Number(cell.posterior_mean.deviation),
           Number(cell.evidence.mean),
           Number(cell.evidence.deviation),
           paper == nullptr ? "" : paper->dominant,
           paper == nullptr ? "" : std::to_string(paper->dominant_run_count),
           mean(&PaperCell::switches),
           deviation(&PaperCell::switches),
           mean(&PaperCell::active_percent),
           deviation(&PaperCell::active_percent),
           mean(&PaperCell::posterior_mean),
           deviation(&PaperCell::posterior_mean),
           mean(&PaperCell::evidence),
           deviation(&PaperCell::evidence)});
}

Status WriteTable4(std::span<const CellSummary> cells, const std::filesystem::path& path) {
  auto csv = CreateTable4(path);
  if (!csv.ok()) return csv.status();
  for (const CellSummary& cell : cells) Table4Row(cell, **csv);
  return (*csv)->Commit();
}

Status WriteTables(std::span<const CellSummary> cells, const std::filesystem::path& folder) {
  if (Status status = WriteTable3(cells, folder / "table3.csv"); !status.ok()) return status;
  return WriteTable4(cells, folder / "table4.csv");
}

using CellRows = std::function<void(const CellTruth& truth, const std::string& cell, CsvFile& csv)>;

Status WriteCells(const ExperimentTruths& truths, const std::filesystem::path& path,
                  std::initializer_list<std::string_view> header, const CellRows& rows) {
  auto csv = CsvFile::Create(path, header);
  if (!csv.ok()) return csv.status();
  for (const CellTruth& truth : truths.cells) rows(truth, truth.cell.label(), **csv);
  return (*csv)->Commit();
}

void RankingRows(const CellTruth& truth, const std::string& cell, CsvFile& csv) {
  for (const ArmCost& arm : truth.ranking) {
    csv.Row({cell, arm.arm, Fixed(arm.mean_ns, 1), Exact(arm.ratio), Exact(truth.control_ratio)});
  }
}

void RegretRows(const CellTruth& truth, const std::string& cell, CsvFile& csv) {
  for (const ReplayedPlayer& player : truth.players) {
    for (size_t i = 0; i < player.regrets.size(); ++i) {
      csv.Row({cell, player.name, std::to_string(i + 1), Exact(player.regrets[i]),
               Exact(player.regret), Exact(player.ci95.low), Exact(player.ci95.high)});
    }
  }
}

void AgreementRows(const CellTruth& truth, const std::string& cell, CsvFile& csv) {
  for (const Agreement& each : truth.agreements) {
    csv.Row({cell, each.policy, std::to_string(each.runs.size()), Exact(each.regret),
             Exact(each.replayed_regret.low), Exact(each.replayed_regret.high),
             each.regret_agrees() ? "1" : "0", Exact(each.active_share),
             Exact(each.replayed_active_share.low), Exact(each.replayed_active_share.high),
             each.share_agrees() ? "1" : "0", Exact(each.measured_regret)});
  }
}

void LiveRegretRows(const CellTruth& truth, const std::string& cell, CsvFile& csv) {
  for (const Agreement& each : truth.agreements) {
    for (const LiveRegret& run : each.runs) {
      csv.Row({cell, each.policy, std::to_string(run.run), Exact(run.measured), Exact(run.by_trace),
               Exact(run.active_share)});
    }
  }
}

void ComparisonRow(const PairedComparison& each, const std::string& cell, CsvFile& csv) {
  csv.Row({cell, each.policy, each.baseline, std::to_string(each.wilcoxon.pair_count),
           Exact(each.difference), Exact(each.ci95.low), Exact(each.ci95.high),
           Exact(each.wilcoxon.probability), Exact(each.corrected_probability),
           Exact(each.wilcoxon.rank_correlation)});
}

Status WriteComparisons(const ExperimentTruths& truths, const std::filesystem::path& path) {
  auto csv = CsvFile::Create(path, {"cell", "policy", "baseline", "pairs", "difference", "ci95_low",
                                    "ci95_high", "p_wilcoxon", "p_holm", "rank_biserial"});
  if (!csv.ok()) return csv.status();
  for (const PairedComparison& each : truths.over_cells) ComparisonRow(each, "all", **csv);
  for (const PairedComparison& each : truths.over_live) ComparisonRow(each, "live", **csv);
  for (const CellTruth& truth : truths.cells) {
    for (const PairedComparison& each : truth.comparisons) {
      ComparisonRow(each, truth.cell.label(), **csv);
    }
  }
  return (*csv)->Commit();
}

Status WriteTruthCsv(const ExperimentTruths& truths, const std::filesystem::path& folder) {
  Status status =
      WriteCells(truths, folder / "ranking.csv",
                 {"cell", "arm", "detection_ns_mean", "ratio", "control_ratio"}, RankingRows);
  if (status.ok()) {
    status = WriteCells(truths, folder / "regret.csv",
                        {"cell", "player", "seed", "regret", "mean", "ci95_low", "ci95_high"},
                        RegretRows);
  }
  if (status.ok()) {
    status =
        WriteCells(truths, folder / "agreement.csv",
                   {"cell", "policy", "live_runs", "live_regret", "replay_regret_low",
                    "replay_regret_high", "regret_agrees", "live_active_share", "replay_share_low",
                    "replay_share_high", "share_agrees", "measured_regret"},
                   AgreementRows);
  }
  if (status.ok()) {
    status =
        WriteCells(truths, folder / "live_regret.csv",
                   {"cell", "policy", "run", "measured_regret", "regret_by_trace", "active_share"},
                   LiveRegretRows);
  }
  return status.ok() ? WriteComparisons(truths, folder / "comparisons.csv") : status;
}

}  // namespace

Status WriteExperimentCsv(const ExperimentReport& report, const std::filesystem::path& folder) {
  Status status = WriteTables(report.cells, folder);
  if (status.ok()) status = WriteRawCsv(report.records, folder);
  return status.ok() ? WriteTruthCsv(report.truths, folder) : status;
}

}  // namespace sweepstake::cli
