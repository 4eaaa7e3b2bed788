#include "engine_client/cli/experiment/experiment_truth_output.h"

#include <functional>

#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

std::string Exact(double value) { return Fixed(value, 9); }

std::string IntervalText(const Interval& interval) {
  return PercentText(interval.low) + " to " + PercentText(interval.high);
}

void PrintRanking(const ExperimentReport& report, std::ostream& out) {
  out << "\nTrue ranking: mean detection time on the same frames, ÷ the fastest’s\n\n";
  std::vector<std::string> header{"cell"};
  for (size_t place = 1; place <= report.truths.front().ranking.size(); ++place) {
    header.push_back(std::to_string(place));
  }
  TextTable table(header);
  for (const CellTruth& truth : report.truths) {
    std::vector<std::string> row{CellName(truth.cell)};
    for (const ArmCost& arm : truth.ranking) row.push_back(arm.arm + " " + Fixed(arm.ratio, 2));
    table.AddRow(std::move(row));
  }
  table.Print(out);
}

void PrintRegret(const ExperimentReport& report, std::ostream& out) {
  out << "\nRegret by replay against the best fixed arm, start and exploration included\n\n";
  TextTable table({"cell", "player", "regret", "95 %", "after start-up", "switches"});
  for (const CellTruth& truth : report.truths) {
    for (const ReplayedPlayer& player : truth.players) {
      if (!player.is_policy) continue;
      table.AddRow({CellName(truth.cell), player.name, PercentText(player.regret),
                    IntervalText(player.ci95), PercentText(player.after_start_up),
                    Fixed(player.switches, 1)});
    }
  }
  table.Print(out);
}

void PrintAgreement(const ExperimentReport& report, std::ostream& out) {
  out << "\nLive against replay under the same conditions\n\n";
  TextTable table({"cell", "policy", "live regret", "replay expects", "", "live active share",
                   "replay expects", "", "regret by the clock"});
  for (const CellTruth& truth : report.truths) {
    for (const Agreement& each : truth.agreements) {
      table.AddRow({CellName(truth.cell), each.policy, PercentText(each.regret),
                    IntervalText(each.replayed_regret), each.regret_agrees() ? "in" : "OUTSIDE",
                    ShareText(each.active_share),
                    ShareText(each.replayed_active_share.low) + " to " +
                        ShareText(each.replayed_active_share.high),
                    each.share_agrees() ? "in" : "OUTSIDE", PercentText(each.measured_regret)});
    }
  }
  table.Print(out);
}

void PrintComparisons(const ExperimentReport& report, std::ostream& out) {
  out << "\n"
      << PolicyTitle("default")
      << " against each baseline over the cells (negative: loses less)\n\n";
  TextTable table({"baseline", "difference", "95 %", "p (Wilcoxon)", "p (Holm)", "effect"});
  for (const PairedComparison& each : report.over_cells) {
    table.AddRow({each.baseline, PercentText(each.difference), IntervalText(each.ci95),
                  Fixed(each.wilcoxon.probability, 4), Fixed(each.corrected_probability, 4),
                  Fixed(each.wilcoxon.rank_correlation, 2)});
  }
  table.Print(out);
}

using CellRows = std::function<void(const CellTruth& truth, const std::string& cell, CsvFile& csv)>;

Status WriteCells(const ExperimentReport& report, const std::filesystem::path& path,
                  std::initializer_list<std::string_view> header, const CellRows& rows) {
  auto csv = CsvFile::Create(path, header);
  if (!csv.ok()) return csv.status();
  for (const CellTruth& truth : report.truths) rows(truth, truth.cell.label(), **csv);
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

Status WriteComparisons(const ExperimentReport& report, const std::filesystem::path& path) {
  auto csv = CsvFile::Create(path, {"cell", "policy", "baseline", "pairs", "difference", "ci95_low",
                                    "ci95_high", "p_wilcoxon", "p_holm", "rank_biserial"});
  if (!csv.ok()) return csv.status();
  for (const PairedComparison& each : report.over_cells) ComparisonRow(each, "all", **csv);
  for (const PairedComparison& each : report.over_live) ComparisonRow(each, "live", **csv);
  for (const CellTruth& truth : report.truths) {
    for (const PairedComparison& each : truth.comparisons) {
      ComparisonRow(each, truth.cell.label(), **csv);
    }
  }
  return (*csv)->Commit();
}

}  // namespace

void PrintTruth(const ExperimentReport& report, std::ostream& out) {
  if (report.truths.empty()) return;
  PrintRanking(report, out);
  if (report.over_cells.empty()) return;
  PrintRegret(report, out);
  PrintAgreement(report, out);
  PrintComparisons(report, out);
}

Status WriteTruthCsv(const ExperimentReport& report, const std::filesystem::path& folder) {
  Status status =
      WriteCells(report, folder / "ranking.csv",
                 {"cell", "arm", "detection_ns_mean", "ratio", "control_ratio"}, RankingRows);
  if (status.ok()) {
    status = WriteCells(report, folder / "regret.csv",
                        {"cell", "player", "seed", "regret", "mean", "ci95_low", "ci95_high"},
                        RegretRows);
  }
  if (status.ok()) {
    status =
        WriteCells(report, folder / "agreement.csv",
                   {"cell", "policy", "live_runs", "live_regret", "replay_regret_low",
                    "replay_regret_high", "regret_agrees", "live_active_share", "replay_share_low",
                    "replay_share_high", "share_agrees", "measured_regret"},
                   AgreementRows);
  }
  if (status.ok()) {
    status =
        WriteCells(report, folder / "live_regret.csv",
                   {"cell", "policy", "run", "measured_regret", "regret_by_trace", "active_share"},
                   LiveRegretRows);
  }
  return status.ok() ? WriteComparisons(report, folder / "comparisons.csv") : status;
}

}  // namespace sweepstake::cli
