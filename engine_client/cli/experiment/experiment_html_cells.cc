#include "engine_client/cli/experiment/experiment_html_cells.h"

#include <algorithm>
#include <array>
#include <set>

#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/experiment/experiment_tables.h"
#include "engine_client/cli/html/stacked_bars.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using html::Element;
using html::Markup;

std::vector<const CellSummary*> CellsOf(const ExperimentReport& report, const std::string& policy) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& cell : report.cells) {
    if (cell.policy == policy) cells.push_back(&cell);
  }
  return cells;
}

// Sizes of the report, ascending; each is a column.
std::vector<uint32_t> Sizes(const ExperimentReport& report) {
  std::set<uint32_t> sizes;
  for (const CellSummary& cell : report.cells) sizes.insert(cell.cell.object_count);
  return {sizes.begin(), sizes.end()};
}

Markup DominanceCell(const ExperimentReport& report, const CellSummary& cell) {
  Markup content;
  for (const auto& [arm, count] : cell.dominance) {
    content +=
        ArmChip(arm, arm + " " + std::to_string(count) + "/" + std::to_string(cell.runs.size())) +
        " ";
  }
  std::string note = "active " + ShareText(cell.active_percent.mean / 100);
  if (const CellTruth* truth = report.TruthOf(cell.cell)) {
    const std::string& fastest = truth->ranking.front().arm;
    note += fastest == cell.dominance.front().first ? "; truly the fastest"
                                                    : "; truly fastest: " + fastest;
  }
  return content + Element("small", {}, note);
}

html::Table DominanceTable(const ExperimentReport& report, const std::string& policy,
                           size_t number) {
  html::Table table{
      "dominance-" + std::to_string(number),
      PolicyTitle(policy) + ": the algorithm that was active longest, and in how many runs",
      {{html::TableCell("Scenario")}},
      {{}}};
  const auto cells = CellsOf(report, policy);
  for (const uint32_t size : Sizes(report)) {
    table.head[0].push_back({html::Grouped(size) + " objects", "text"});
  }
  std::vector<std::string> scenes;
  for (const CellSummary* cell : cells) {
    if (std::find(scenes.begin(), scenes.end(), cell->cell.scene) == scenes.end()) {
      scenes.push_back(cell->cell.scene);
    }
  }
  for (const std::string& scene : scenes) {
    std::vector<html::TableCell> row{html::TableCell(PaperSceneName(scene))};
    for (const uint32_t size : Sizes(report)) {
      const auto cell = std::find_if(cells.begin(), cells.end(), [&](const CellSummary* each) {
        return each->cell.scene == scene && each->cell.object_count == size;
      });
      row.push_back({cell == cells.end() ? Markup("–") : DominanceCell(report, **cell), "text"});
    }
    table.groups[0].rows.push_back(std::move(row));
  }
  return table;
}

std::vector<html::TableCell> Table3Row(const CellSummary& cell) {
  const PaperCell* paper = FindPaperCell(cell.cell.scene, cell.cell.object_count);
  const auto printed = [&](std::string_view PaperCell::*text) {
    return html::TableCell(paper == nullptr ? "–" : std::string(paper->*text), "text wrap");
  };
  return {{PaperSceneName(cell.cell.scene)},   {html::Grouped(cell.cell.object_count)},
          {cell.DominanceText(), "text wrap"}, {cell.Interpretation(), "text wrap"},
          printed(&PaperCell::dominance),      printed(&PaperCell::interpretation)};
}

// Ours, and the paper's figure below it.
html::TableCell WithPaper(const std::string& ours, const std::string& paper) {
  return {Markup(ours) + Element("small", {}, paper)};
}

std::vector<html::TableCell> Table4Row(const CellSummary& cell) {
  const auto& [dominant, count] = cell.dominance.front();
  const std::string frequency = std::to_string(count) + " / " + std::to_string(cell.runs.size());
  const PaperCell* paper = FindPaperCell(cell.cell.scene, cell.cell.object_count);
  const auto printed = [&](PaperFigure PaperCell::*figure, int decimals) {
    return paper == nullptr ? std::string("–") : PaperText(paper->*figure, decimals);
  };
  const std::string paper_frequency = paper == nullptr ? "–"
                                                       : std::to_string(paper->dominant_run_count) +
                                                             " / " + std::to_string(kPaperRunCount);
  return {{PaperSceneName(cell.cell.scene)},
          {html::Grouped(cell.cell.object_count)},
          {ArmChip(dominant) +
               Element("small", {}, paper == nullptr ? "–" : std::string(paper->dominant)),
           "text"},
          WithPaper(frequency, paper_frequency),
          WithPaper(SpreadText(cell.switches, 1), printed(&PaperCell::switches, 1)),
          WithPaper(SpreadText(cell.active_percent, 1), printed(&PaperCell::active_percent, 1)),
          WithPaper(SpreadText(cell.posterior_mean, 3), printed(&PaperCell::posterior_mean, 3)),
          WithPaper(SpreadText(cell.evidence, 1), printed(&PaperCell::evidence, 1))};
}

html::StackedRow MeanRow(const CellSummary& cell, const std::vector<double>& values) {
  return {CellName(cell.cell), PolicyTitle(cell.policy), values};
}

std::vector<double> MeanActiveShares(const CellSummary& cell) {
  std::vector<double> shares(ArmKinds().size());
  for (const RunSummary& run : cell.runs) {
    for (size_t arm = 0; arm < run.active_shares.size(); ++arm) {
      shares[ArmKind(run.record->arms[arm])] += run.active_shares[arm];
    }
  }
  return shares;
}

std::vector<double> DecisionsByVerdict(const CellSummary& cell) {
  std::vector<double> counts(5);
  for (const RunSummary& run : cell.runs) {
    for (const RecordedDecision& decision : run.record->decisions) {
      if (decision.time_s >= run.record->exploration_s && decision.verdict < counts.size()) {
        ++counts[decision.verdict];
      }
    }
  }
  return counts;
}

// The parts of a run's time, in ns: those of the frame thread, then the other threads'.
constexpr size_t kFramePartCount = 6;
constexpr size_t kTimePartCount = 9;
const std::vector<std::string> kTimeParts{
    "Scene step", "Steady detection", "Rebuilds", "Copying in", "Descriptors, switching",
    "Frame end",  "Intake",           "Selector", "Shadow lane"};

std::array<double, kTimePartCount> PartsOf(const CellSummary& cell) {
  std::array<double, kTimePartCount> parts{};
  for (const RunSummary& run : cell.runs) {
    const TimeShares& time = run.record->time;
    const std::array<uint64_t, kTimePartCount> all{
        time.scene_step_ns, time.detection_ns, time.rebuild_ns,  time.copying_ns, time.around_ns,
        time.frame_end_ns,  time.intake_ns,    time.decision_ns, time.lane_ns};
    for (size_t i = 0; i < all.size(); ++i) parts[i] += static_cast<double>(all[i]);
  }
  return parts;
}

std::vector<html::TableCell> TimeRow(const CellSummary& cell) {
  const auto parts = PartsOf(cell);
  double frames_ns = 0;
  for (size_t i = 0; i < kFramePartCount; ++i) frames_ns += parts[i];
  std::vector<html::TableCell> row{{CellName(cell.cell)}};
  for (size_t i = 0; i < parts.size(); ++i) {
    row.push_back({html::Significant(100 * parts[i] / frames_ns, 3) + " %",
                   i == kFramePartCount ? "first" : ""});
  }
  double decisions = 0, longest_ns = 0, dropped = 0;
  for (const RunSummary& run : cell.runs) {
    decisions += static_cast<double>(run.record->decisions.size());
    longest_ns = std::max(longest_ns, static_cast<double>(run.record->time.longest_decision_ns));
    dropped += static_cast<double>(run.record->dropped_frame_count);
  }
  row.push_back({MicrosecondsText(parts[7] / std::max(decisions, 1.0)), "first"});
  row.push_back({MicrosecondsText(longest_ns)});
  row.push_back({html::GroupedWhole(dropped)});
  return row;
}

}  // namespace

Markup DominanceGrid(const ExperimentReport& report) {
  Markup grid;
  for (size_t i = 0; i < report.plan.options.policies.size(); ++i) {
    const std::string& policy = report.plan.options.policies[i];
    if (!CellsOf(report, policy).empty()) {
      grid += html::DrawTable(DominanceTable(report, policy, i + 1));
    }
  }
  return grid;
}

Markup PaperTables(const ExperimentReport& report) {
  html::Table third{"table-3",
                    "Table 3. Dominant algorithms across the runs of each scenario and size",
                    {{{"Scenario"},
                      {"Objects"},
                      {"Dominance frequency", "text"},
                      {"Interpretation", "text"},
                      {"Paper: frequency", "text"},
                      {"Paper: interpretation", "text"}}},
                    {}};
  html::Table fourth{"table-4",
                     "Table 4. Switches over all runs; active time, μ* and n* over the runs in "
                     "which the arm dominated; mean ± sample standard deviation. Below each figure "
                     "the paper’s",
                     {{{"Scenario"},
                       {"Obj."},
                       {"Dominant", "text"},
                       {"Freq."},
                       {"Switches"},
                       {"Active (%)"},
                       {"μ*"},
                       {"n*"}}},
                     {}};
  for (const std::string& policy : report.plan.options.policies) {
    html::TableGroup third_group{"Policy " + PolicyTitle(policy), {}};
    html::TableGroup fourth_group = third_group;
    for (const CellSummary* cell : CellsOf(report, policy)) {
      third_group.rows.push_back(Table3Row(*cell));
      fourth_group.rows.push_back(Table4Row(*cell));
    }
    if (third_group.rows.empty()) continue;
    third.groups.push_back(std::move(third_group));
    fourth.groups.push_back(std::move(fourth_group));
  }
  return html::DrawTable(third) + html::DrawTable(fourth);
}

Markup ActiveShares(const ExperimentReport& report) {
  html::StackedBars chart{"active-shares",
                          "Active share of each algorithm",
                          "Of the observation window, mean over the runs.",
                          ArmKinds(),
                          {}};
  for (const CellSummary& cell : report.cells) {
    chart.rows.push_back(MeanRow(cell, MeanActiveShares(cell)));
  }
  return html::DrawStackedBars(chart);
}

Markup VerdictShares(const ExperimentReport& report) {
  html::StackedBars chart{"verdict-shares",
                          "What the posteriors said",
                          "Share of the decisions in the observation window.",
                          {"Nothing learnt", "Stable", "Tie", "Ambiguous", "Degraded"},
                          {}};
  for (const CellSummary& cell : report.cells) {
    chart.rows.push_back(MeanRow(cell, DecisionsByVerdict(cell)));
  }
  return html::DrawStackedBars(chart);
}

Markup TimeParts(const ExperimentReport& report) {
  html::StackedBars chart{"time-shares",
                          "The frame thread’s time",
                          "Means over the runs. What is too narrow to see is in the table.",
                          {kTimeParts.begin(), kTimeParts.begin() + kFramePartCount},
                          {}};
  html::Table table{"time-table",
                    "In percent of the frames’ time. Intake, selector and shadow lane run on other "
                    "threads meanwhile, and take nothing from the frame",
                    {{{""},
                      {"Frame thread", "first", kFramePartCount},
                      {"Other threads", "first", kTimePartCount - kFramePartCount},
                      {"Selector", "first", 2},
                      {""}},
                     {{"Cell"}}},
                    {}};
  for (size_t i = 0; i < kTimeParts.size(); ++i) {
    table.head[1].push_back({kTimeParts[i], i == kFramePartCount ? "first" : ""});
  }
  table.head[1].push_back({"a decision", "first"});
  table.head[1].push_back({"longest"});
  table.head[1].push_back({"Samples lost"});
  for (const CellSummary& cell : report.cells) {
    const auto parts = PartsOf(cell);
    chart.rows.push_back(MeanRow(cell, {parts.begin(), parts.begin() + kFramePartCount}));
    const std::string title = "Policy " + PolicyTitle(cell.policy);
    if (table.groups.empty() || table.groups.back().title.html() != Markup(title).html()) {
      table.groups.push_back({title, {}});
    }
    table.groups.back().rows.push_back(TimeRow(cell));
  }
  return html::DrawStackedBars(chart) + html::DrawTable(table);
}

}  // namespace sweepstake::cli
