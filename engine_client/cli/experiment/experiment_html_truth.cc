#include "engine_client/cli/experiment/experiment_html_truth.h"

#include <algorithm>
#include <map>

#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/html/range_chart.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using html::Element;
using html::Markup;

// Percent; what loses less, or wins, stands at the left edge of the logarithmic axis.
constexpr double kLeastPercent = 0.01;

double OnAxis(double ratio) { return std::max(100 * ratio, kLeastPercent); }

std::string IntervalText(const Interval& interval) {
  return PercentText(interval.low) + " to " + PercentText(interval.high);
}

std::string ProbabilityText(double probability) {
  return probability < 0.0001 ? "< 0.0001" : html::Significant(probability, 2);
}

// Ours in one colour, the paper's in another, the other baselines in a third, arms and oracle in
// grey.
html::SeriesStyle StyleOf(const std::string& name, bool is_policy) {
  if (name == OwnPolicyName("default")) return {0, true};
  if (name == "paper") return {4, true};
  return is_policy ? html::SeriesStyle{3, true} : html::SeriesStyle{7, false};
}

html::RangeRow RowOf(const ReplayedPlayer& player) {
  const std::string title = player.is_policy ? PolicyTitle(player.name) : player.name;
  return {title,
          StyleOf(player.name, player.is_policy),
          OnAxis(player.ci95.low),
          OnAxis(player.regret),
          OnAxis(player.ci95.high),
          PercentText(player.regret),
          PercentText(player.regret) + " (95 %: " + IntervalText(player.ci95) +
              ")\nafter start-up " + PercentText(player.after_start_up)};
}

void SortByValue(std::vector<html::RangeRow>& rows) {
  std::stable_sort(rows.begin(), rows.end(), [](const html::RangeRow& a, const html::RangeRow& b) {
    return a.value < b.value;
  });
}

Markup CellChart(const CellTruth& truth, size_t number) {
  html::RangeChart chart{"regret-" + std::to_string(number),
                         CellName(truth.cell),
                         "",
                         "Percent of frame time lost to the best fixed algorithm; the bar is the "
                         "95 % interval",
                         {}};
  for (const ReplayedPlayer& player : truth.players) chart.rows.push_back(RowOf(player));
  SortByValue(chart.rows);
  return html::DrawRangeChart(chart);
}

// Of each player the mean over the cells, and as its bar the least and the largest.
Markup OverviewChart(const std::vector<const CellTruth*>& truths) {
  struct OverCells {
    bool is_policy = false;
    std::vector<double> regrets;
  };
  std::map<std::string, OverCells> players;
  for (const CellTruth* truth : truths) {
    for (const ReplayedPlayer& player : truth->players) {
      players[player.name].is_policy = player.is_policy;
      players[player.name].regrets.push_back(player.regret);
    }
  }
  html::RangeChart chart{"regret-over-cells",
                         "All cells together",
                         "The mark is the mean over the cells; the bar reaches from the best cell "
                         "to the worst.",
                         "Percent of frame time lost to the best fixed algorithm",
                         {}};
  for (const auto& [name, over] : players) {
    const auto [least, most] = std::minmax_element(over.regrets.begin(), over.regrets.end());
    const double mean = Mean(over.regrets);
    chart.rows.push_back({over.is_policy ? PolicyTitle(name) : name, StyleOf(name, over.is_policy),
                          OnAxis(*least), OnAxis(mean), OnAxis(*most), PercentText(mean),
                          "mean " + PercentText(mean) + ", from " + PercentText(*least) + " to " +
                              PercentText(*most)});
  }
  SortByValue(chart.rows);
  return html::DrawRangeChart(chart);
}

html::Table RegretTable(const std::vector<const CellTruth*>& truths) {
  html::Table table{"regret-table",
                    "Mean regret of each player over its games, start and exploration included; "
                    "below it after the start-up. The lowest policy of each cell is marked",
                    {{{"Player"}}},
                    {{}}};
  for (const CellTruth* truth : truths) table.head[0].push_back({CellName(truth->cell)});
  for (size_t player = 0; player < truths.front()->players.size(); ++player) {
    const ReplayedPlayer& first = truths.front()->players[player];
    std::vector<html::TableCell> row{{first.is_policy ? PolicyTitle(first.name) : first.name}};
    for (const CellTruth* truth : truths) {
      const ReplayedPlayer& each = truth->players[player];
      const bool best =
          each.is_policy && std::none_of(truth->players.begin(), truth->players.end(),
                                         [&](const ReplayedPlayer& other) {
                                           return other.is_policy && other.regret < each.regret;
                                         });
      row.push_back({Markup(PercentText(each.regret)) +
                         Element("small", {}, PercentText(each.after_start_up)),
                     best ? "best" : ""});
    }
    table.groups[0].rows.push_back(std::move(row));
  }
  return table;
}

std::vector<const CellTruth*> Replayed(const ExperimentReport& report) {
  std::vector<const CellTruth*> replayed;
  for (const CellTruth& truth : report.truths) {
    if (!truth.players.empty()) replayed.push_back(&truth);
  }
  return replayed;
}

html::TableCell AgreeCell(bool agrees, const std::string& live, const std::string& interval) {
  return {Markup(live) + Element("small", {{"class", agrees ? "verdict met" : "verdict missed"}},
                                 (agrees ? "✓ in " : "✗ outside ") + interval),
          agrees ? "met" : "missed"};
}

std::string ShareInterval(const Interval& interval) {
  return ShareText(interval.low) + " to " + ShareText(interval.high);
}

struct AgreementViews {
  html::RangeChart regret;
  html::RangeChart share;
  html::Table table;
};

void AddAgreement(const CellTruth& truth, const Agreement& each, AgreementViews& views) {
  const std::string name = CellName(truth.cell) + " · " + PolicyShortName(each.policy);
  views.regret.rows.push_back(
      {name,
       {each.regret_agrees() ? size_t{0} : size_t{4}, each.regret_agrees()},
       OnAxis(each.replayed_regret.low),
       OnAxis(each.regret),
       OnAxis(each.replayed_regret.high),
       PercentText(each.regret),
       "live " + PercentText(each.regret) + ", replay " + IntervalText(each.replayed_regret)});
  views.share.rows.push_back({name,
                              {each.share_agrees() ? size_t{0} : size_t{4}, each.share_agrees()},
                              std::max(100 * each.replayed_active_share.low, 1.0),
                              100 * each.active_share,
                              std::min(100 * each.replayed_active_share.high, 100.0),
                              ShareText(each.active_share),
                              "live " + ShareText(each.active_share) + ", replay " +
                                  ShareInterval(each.replayed_active_share)});
  views.table.groups[0].rows.push_back({{name},
                                        {std::to_string(each.runs.size())},
                                        AgreeCell(each.regret_agrees(), PercentText(each.regret),
                                                  IntervalText(each.replayed_regret)),
                                        AgreeCell(each.share_agrees(), ShareText(each.active_share),
                                                  ShareInterval(each.replayed_active_share)),
                                        {PercentText(each.measured_regret)}});
}

html::TableGroup ComparisonRows(const std::string& title,
                                const std::vector<PairedComparison>& comparisons) {
  html::TableGroup group{title, {}};
  for (const PairedComparison& each : comparisons) {
    group.rows.push_back({{PolicyTitle(each.baseline)},
                          {std::to_string(each.wilcoxon.pair_count)},
                          {PercentText(each.difference)},
                          {IntervalText(each.ci95)},
                          {ProbabilityText(each.wilcoxon.probability)},
                          {ProbabilityText(each.corrected_probability)},
                          {html::Significant(each.wilcoxon.rank_correlation, 2)}});
  }
  return group;
}

}  // namespace

Markup TrueRanking(const ExperimentReport& report) {
  if (report.truths.empty()) return {};
  html::Table table{"ranking",
                    "Mean time to update and search a frame, every algorithm on the same frames; "
                    "how many times the fastest’s",
                    {{{"Cell"}}},
                    {{}}};
  for (size_t place = 1; place <= report.truths.front().ranking.size(); ++place) {
    table.head[0].push_back({std::to_string(place) + ".", "text"});
  }
  table.head[0].push_back({"Same twice"});
  table.head[0].push_back({"Headroom"});
  for (const CellTruth& truth : report.truths) {
    std::vector<html::TableCell> row{{CellName(truth.cell)}};
    for (const ArmCost& arm : truth.ranking) {
      const std::string figure =
          arm.ratio == 1 ? MicrosecondsText(arm.mean_ns) : html::Significant(arm.ratio, 3) + "×";
      row.push_back({ArmChip(arm.arm) + Element("small", {}, figure), "text"});
    }
    row.push_back({PercentText(truth.control_ratio - 1)});
    row.push_back({truth.players.empty() ? "–" : ShareText(truth.headroom)});
    table.groups[0].rows.push_back(std::move(row));
  }
  return html::DrawTable(table);
}

Markup RegretCharts(const ExperimentReport& report) {
  const auto truths = Replayed(report);
  if (truths.empty()) return {};
  Markup cells;
  size_t number = 0;
  for (const CellTruth* truth : truths) cells += CellChart(*truth, ++number);
  return OverviewChart(truths) + html::DrawTable(RegretTable(truths)) +
         Element("details", {}, Element("summary", {}, "Each cell") + cells);
}

Markup LiveAgainstReplay(const ExperimentReport& report) {
  AgreementViews views{{"agreement-regret",
                        "Regret",
                        "Mark: live. Bar: where replay expects it, 95 %.",
                        "Percent of frame time lost to the best fixed algorithm",
                        {}},
                       {"agreement-share",
                        "Active share of the dominant algorithm",
                        "Mark: live. Bar: where replay expects it, 95 %.",
                        "Percent of the observation window",
                        {}},
                       {"agreement",
                        "Live runs against replay under the same conditions",
                        {{{"Cell and policy"},
                          {"Live runs"},
                          {"Regret at the trace’s costs"},
                          {"Active share"},
                          {"Regret as the clock measured it"}}},
                        {{}}}};
  for (const CellTruth& truth : report.truths) {
    for (const Agreement& each : truth.agreements) AddAgreement(truth, each, views);
  }
  if (views.regret.rows.empty()) return {};
  return html::DrawRangeChart(views.regret) + html::DrawRangeChart(views.share) +
         html::DrawTable(views.table);
}

Markup Comparisons(const ExperimentReport& report) {
  if (report.over_cells.empty()) return {};
  html::Table table{"comparisons",
                    PolicyTitle("default") +
                        " against each baseline, paired: the difference of regret (negative: loses "
                        "less), its 95 % bootstrap interval, Wilcoxon’s signed-rank test, its "
                        "probability by Holm’s correction, and the rank-biserial effect size",
                    {{{"Baseline"},
                      {"Pairs"},
                      {"Difference"},
                      {"95 % interval"},
                      {"p"},
                      {"p, corrected"},
                      {"Effect"}}},
                    {}};
  table.groups.push_back(ComparisonRows("Replay, all cells; a pair per cell", report.over_cells));
  if (!report.over_live.empty()) {
    table.groups.push_back(
        ComparisonRows("Live runs at the trace’s costs; a pair per run", report.over_live));
  }
  html::Table by_cell = table;
  by_cell.id = "comparisons-by-cell";
  by_cell.groups.clear();
  for (const CellTruth* truth : Replayed(report)) {
    by_cell.groups.push_back(
        ComparisonRows(CellName(truth->cell) + "; a pair per seed", truth->comparisons));
  }
  return html::DrawTable(table) +
         Element("details", {}, Element("summary", {}, "Each cell") + html::DrawTable(by_cell));
}

}  // namespace sweepstake::cli
