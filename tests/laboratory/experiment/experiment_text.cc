// Prints the text tables of an experiment.
#include <algorithm>
#include <cmath>
#include <span>

#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"
#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/experiment/paper_tables.h"

namespace sweepstake::cli {
namespace {

// Returns the scene's name in the paper's tables; other scenes keep their own name.
std::string PaperSceneName(const std::string& scene) {
  if (scene == "brownian") return "Brownian";
  if (scene == "rotating-gravity") return "Rotating Grav";
  if (scene == "hurricane") return "Hurricane";
  return scene;
}

std::string PaperText(const PaperFigure& figure, int decimals) {
  return Fixed(figure.mean, decimals) + "±" + Fixed(figure.deviation, decimals);
}

// Formats a percentage with two decimals below 10 %, one below 100 %, none above. REQUIRES: ratio
// >= 0.
std::string RoundedPercent(double ratio) {
  if (100 * ratio < 9.995) return Percent(ratio, 2);
  if (100 * ratio < 99.95) return Percent(ratio, 1);
  return GroupedWhole(100 * ratio) + " %";
}

std::string CellName(const ExperimentCell& cell) {
  return PaperSceneName(cell.scene) + " " + Grouped(cell.object_count);
}

std::string PercentText(double ratio) {
  const std::string size = RoundedPercent(std::abs(ratio));
  // A value that rounds to 0 is printed without a sign.
  return size.find_first_not_of("0. %") == std::string::npos ? "0 %"
                                                             : (ratio < 0 ? "−" : "+") + size;
}

std::string PolicyTitle(const std::string& policy) {
  const std::string own = OwnPolicyName("default");
  return OwnPolicyName(policy) == own ? "AI Decides (" + own + ")" : policy;
}

std::string Frequency(uint32_t count, size_t of) {
  return std::to_string(count) + " / " + std::to_string(of);
}

void PrintTable3(std::span<const CellSummary> cells, std::ostream& out) {
  TextTable table({"Scenario", "Objects", "Dominance frequency", "Interpretation", "Paper"});
  for (const CellSummary& cell : cells) {
    const PaperCell* paper = PaperOf(cell);
    table.AddRow({PaperSceneName(cell.cell.scene), Grouped(cell.cell.object_count),
                  cell.DominanceText(), cell.Interpretation(),
                  paper == nullptr ? "–" : std::string(paper->dominance)});
  }
  table.Print(out);
}

void PrintTable4(std::span<const CellSummary> cells, std::ostream& out) {
  TextTable table({"Scenario", "Obj.", "Dominant", "Freq.", "Switches", "Active (%)", "μ* / n*"});
  for (const CellSummary& cell : cells) {
    const auto& [dominant, count] = cell.dominance.front();
    table.AddRow({PaperSceneName(cell.cell.scene), Grouped(cell.cell.object_count), dominant,
                  Frequency(count, cell.runs.size()), SpreadText(cell.switches, 1),
                  SpreadText(cell.active_percent, 1),
                  SpreadText(cell.posterior_mean, 3) + " / " + SpreadText(cell.evidence, 1)});
    const PaperCell* paper = PaperOf(cell);
    if (paper == nullptr) continue;
    table.AddRow({"  paper", "", std::string(paper->dominant),
                  Frequency(paper->dominant_run_count, kPaperRunCount),
                  PaperText(paper->switches, 1), PaperText(paper->active_percent, 1),
                  PaperText(paper->posterior_mean, 3) + " / " + PaperText(paper->evidence, 1)});
  }
  table.Print(out);
}

// Splits the rows by policy. The rows of a policy are consecutive.
std::vector<std::span<const CellSummary>> ByPolicy(std::span<const CellSummary> cells) {
  std::vector<std::span<const CellSummary>> groups;
  for (size_t first = 0; first < cells.size();) {
    size_t end = first + 1;
    while (end < cells.size() && cells[end].policy == cells[first].policy) ++end;
    groups.push_back(cells.subspan(first, end - first));
    first = end;
  }
  return groups;
}

void PrintTables(std::span<const CellSummary> cells, std::ostream& out) {
  for (const auto group : ByPolicy(cells)) {
    const std::string& policy = group.front().policy;
    out << "\nTable 3 with policy " << policy << ". Dominant algorithms across the runs.\n\n";
    PrintTable3(group, out);
    out << "\nTable 4 with policy " << policy
        << ". Switches over all runs; active time, μ* and n* over the dominant runs; mean ± sample "
           "standard deviation.\n\n";
    PrintTable4(group, out);
  }
}

std::string IntervalText(const Interval& interval) {
  return PercentText(interval.low) + " to " + PercentText(interval.high);
}

void PrintRanking(const ExperimentTruths& truths, std::ostream& out) {
  out << "\nTrue ranking: mean detection time on the same frames, ÷ the fastest’s\n\n";
  std::vector<std::string> header{"cell"};
  for (size_t place = 1; place <= truths.cells.front().ranking.size(); ++place) {
    header.push_back(std::to_string(place));
  }
  TextTable table(header);
  for (const CellTruth& truth : truths.cells) {
    std::vector<std::string> row{CellName(truth.cell)};
    for (const ArmCost& arm : truth.ranking) row.push_back(arm.arm + " " + Fixed(arm.ratio, 2));
    table.AddRow(std::move(row));
  }
  table.Print(out);
}

void PrintRegret(const ExperimentTruths& truths, std::ostream& out) {
  out << "\nRegret by replay against the best fixed arm, start and exploration included\n\n";
  TextTable table({"cell", "player", "regret", "95 %", "after start-up", "switches", "ms per frame",
                   "of 60 Hz", "vs worst", "vs median", "vs paper", "lane"});
  for (const CellTruth& truth : truths.cells) {
    for (const ReplayedPlayer& player : truth.players) {
      if (!player.is_policy) continue;
      table.AddRow({CellName(truth.cell), player.name, PercentText(player.regret),
                    IntervalText(player.ci95),
                    player.after_start_up ? PercentText(*player.after_start_up) : "-",
                    Fixed(player.switches, 1), Fixed(player.ms.regret(), 4),
                    Percent(player.ms.regret() / kFrameMsAt60Hz, 3),
                    Fixed(player.ms.detection - player.ms.worst, 4),
                    Fixed(player.ms.detection - player.ms.median, 4),
                    player.paper_ms ? Fixed(player.ms.detection - *player.paper_ms, 4) : "-",
                    Fixed(player.ms.lane, 4)});
    }
  }
  table.Print(out);
}

void PrintAgreement(const ExperimentTruths& truths, std::ostream& out) {
  out << "\nLive against replay under the same conditions\n\n";
  TextTable table({"cell", "policy", "live regret", "replay expects", "", "live active share",
                   "replay expects", "", "regret by the clock"});
  for (const CellTruth& truth : truths.cells) {
    for (const Agreement& each : truth.agreements) {
      table.AddRow({CellName(truth.cell), each.policy, PercentText(each.regret),
                    IntervalText(each.replayed_regret), each.regret_agrees() ? "in" : "OUTSIDE",
                    RoundedPercent(each.active_share),
                    RoundedPercent(each.replayed_active_share.low) + " to " +
                        RoundedPercent(each.replayed_active_share.high),
                    each.share_agrees() ? "in" : "OUTSIDE", PercentText(each.measured_regret)});
    }
  }
  table.Print(out);
}

void PrintComparisons(const ExperimentTruths& truths, std::ostream& out) {
  out << "\n"
      << PolicyTitle("default")
      << " against each baseline over the cells (negative: less regret)\n\n";
  TextTable table({"baseline", "difference", "95 %", "p (Wilcoxon)", "p (Holm)", "effect"});
  for (const PairedComparison& each : truths.over_cells) {
    table.AddRow({each.baseline, PercentText(each.difference), IntervalText(each.ci95),
                  Fixed(each.wilcoxon.probability, 4), Fixed(each.corrected_probability, 4),
                  Fixed(each.wilcoxon.rank_correlation, 2)});
  }
  table.Print(out);
}

void PrintTruth(const ExperimentTruths& truths, std::ostream& out) {
  if (truths.cells.empty()) return;
  PrintRanking(truths, out);
  if (truths.over_cells.empty()) return;
  PrintRegret(truths, out);
  PrintAgreement(truths, out);
  PrintComparisons(truths, out);
}

}  // namespace

std::string SpreadText(const Spread& spread, int decimals) {
  const std::string mean = Fixed(spread.mean, decimals);
  return spread.count > 1 ? mean + "±" + Fixed(spread.deviation, decimals) : mean;
}

void PrintExperiment(const ExperimentReport& report, const std::filesystem::path& folder,
                     std::ostream& out) {
  if (!report.complete()) {
    out << "PARTIAL: " << report.records.size() << " of " << report.plan.runs.size()
        << " runs; continue with --resume " << folder.string() << "\n";
  }
  PrintTables(report.cells, out);
  PrintTruth(report.truths, out);
}

}  // namespace sweepstake::cli
