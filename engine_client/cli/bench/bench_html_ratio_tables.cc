// The tables of what was compared with what: made of the report's ratios.
#include <algorithm>
#include <array>

#include "engine_client/cli/bench/bench_html_columns.h"
#include "engine_client/cli/bench/bench_html_tables.h"
#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

using html::Element;
using html::Grouped;
using html::Markup;
using html::TableCell;

// A kind of goal in words.
struct GoalKind {
  RatioKind kind;
  const char* title;
  const char* meaning;
};
constexpr std::array<GoalKind, 6> kGoalKinds{{
    {RatioKind::kOverall, "Best against best",
     "our fastest backend is so many times faster than the fastest peer"},
    {RatioKind::kFamily, "Family against family",
     "each backend is so many times faster than the best peer that works alike"},
    {RatioKind::kGrowth, "Growth",
     "time per object grows by no more than this from 10,000 objects to the most"},
    {RatioKind::kThreads, "Threads", "several threads are so many times faster than one"},
    {RatioKind::kSpike, "Steady frames",
     "one frame in a hundred takes no longer than so many medians"},
    {RatioKind::kMemory, "Memory", "bytes held, pairs included, against the goal's bytes"},
}};

std::vector<const BenchRatio*> RatiosOf(const BenchReport& report, RatioKind kind) {
  std::vector<const BenchRatio*> ratios;
  for (const BenchRatio& ratio : report.ratios) {
    if (ratio.kind == kind) ratios.push_back(&ratio);
  }
  return ratios;
}

// A contestant's name with its time in the cell.
Markup WithTime(const BenchIndex& index, size_t cell, const std::string& name, uint32_t threads) {
  const BenchRow* row = index.Find(cell, name, threads);
  Markup text = ContestantTitle(name, threads);
  if (row != nullptr) text += Element("small", {}, Milliseconds(row->ms_median) + " ms");
  return text;
}

// How many times faster, whether that is enough, and than whom.
TableCell Comparison(const BenchIndex& index, const BenchRatio& ratio) {
  Markup other = ratio.other;
  if (!ratio.derived_through.empty()) {
    other += ", through " + ratio.derived_through;
  } else if (const BenchRow* row = index.Find(ratio.cell, ratio.other, 1);
             row != nullptr && ratio.thread_count == 1) {
    // Against several threads of ours the peer may have had several, too.
    // A peer that was stopped is compared over its own frames only, of which ours has another
    // median.
    other += row->note.empty() ? ", " + Milliseconds(row->ms_median) + " ms"
                               : ", over its " + Grouped(row->frame_count) + " frames";
  }
  return {Element("b", {}, Times(ratio.value)) + Verdict(ratio) + Element("small", {}, other),
          VerdictClass(ratio)};
}

// The cell's comparison of our best with so many threads; null when there is none.
const BenchRatio* OverallRatio(const BenchIndex& index, size_t cell, uint32_t thread_count,
                               bool published) {
  for (const BenchRatio& ratio : index.report().ratios) {
    if (ratio.kind == RatioKind::kOverall && ratio.cell == cell &&
        ratio.thread_count == thread_count && ratio.derived_through.empty() != published) {
      return &ratio;
    }
  }
  return nullptr;
}

// The cells of a row of the overall table; none when there is nothing to compare.
std::vector<TableCell> OverallRow(const BenchIndex& index, size_t cell, uint32_t thread_count) {
  const BenchRatio* measured = OverallRatio(index, cell, thread_count, false);
  const BenchRatio* published = OverallRatio(index, cell, thread_count, true);
  const BenchRatio* any = measured != nullptr ? measured : published;
  if (any == nullptr) return {};
  const bool has_mean = measured != nullptr && measured->value_mean;
  return {{Grouped(index.report().cells[cell].object_count)},
          {WithTime(index, cell, any->ours, thread_count), "text"},
          measured != nullptr ? Comparison(index, *measured) : NoValue(),
          {has_mean ? Times(*measured->value_mean) : "–"},
          published != nullptr ? Comparison(index, *published) : NoValue()};
}

// Comparisons of one of ours that make one row of the family table.
struct FamilyLine {
  std::string ours;
  uint32_t thread_count;
  std::string published;  // the peer that did not run; empty: the best of those that ran

  bool Has(const BenchRatio& ratio) const {
    return ratio.ours == ours && ratio.thread_count == thread_count &&
           (ratio.derived_through.empty() ? "" : ratio.other) == published;
  }
};

std::vector<FamilyLine> FamilyLines(const std::vector<const BenchRatio*>& ratios) {
  std::vector<FamilyLine> lines;
  for (const BenchRatio* ratio : ratios) {
    const bool known = std::any_of(lines.begin(), lines.end(),
                                   [&](const FamilyLine& line) { return line.Has(*ratio); });
    if (known) continue;
    lines.push_back(
        {ratio->ours, ratio->thread_count, ratio->derived_through.empty() ? "" : ratio->other});
  }
  const auto known = BroadPhaseNames();
  std::stable_sort(lines.begin(), lines.end(), [&](const FamilyLine& a, const FamilyLine& b) {
    return std::find(known.begin(), known.end(), a.ours) <
           std::find(known.begin(), known.end(), b.ours);
  });
  return lines;
}

TableCell FamilyCell(const std::vector<const BenchRatio*>& ratios, size_t cell,
                     const FamilyLine& line) {
  for (const BenchRatio* ratio : ratios) {
    if (ratio->cell != cell || !line.Has(*ratio)) continue;
    Markup content = Times(ratio->value) + Verdict(*ratio);
    if (line.published.empty()) content += Element("small", {}, ratio->other);
    return {content, VerdictClass(*ratio)};
  }
  return NoValue();
}

std::vector<TableCell> FamilyRow(const BenchIndex& index,
                                 const std::vector<const BenchRatio*>& ratios,
                                 const FamilyLine& line) {
  std::vector<TableCell> row{
      {line.published.empty()
           ? Markup("best peer that ran")
           : Markup(line.published) + Element("small", {}, "did not run: by published ratios")}};
  for (const size_t cell : index.cells()) row.push_back(FamilyCell(ratios, cell, line));
  SeparateScenes(index, row);
  return row;
}

Markup MissedList(const BenchIndex& index, const std::vector<const BenchRatio*>& ratios) {
  Markup items;
  for (const BenchRatio* ratio : ratios) {
    if (!ratio->goal || ratio->met) continue;
    items += Element("li", {},
                     ContestantTitle(ratio->ours, ratio->thread_count) + " in " +
                         CellTitle(index.report(), ratio->cell) + ": " + Times(ratio->value) +
                         (ratio->other.empty() ? "" : " (" + ratio->other + ")") + ", goal " +
                         html::Compact(*ratio->goal) + "×");
  }
  if (items.empty()) return Element("span", {{"class", "none"}}, "none");
  return Element("details", {}, Element("summary", {}, "Show which") + Element("ul", {}, items));
}

std::vector<TableCell> GoalRow(const BenchIndex& index, const GoalKind& kind) {
  const auto ratios = RatiosOf(index.report(), kind.kind);
  const auto goals = std::count_if(ratios.begin(), ratios.end(),
                                   [](const BenchRatio* ratio) { return ratio->goal.has_value(); });
  const auto met = std::count_if(ratios.begin(), ratios.end(),
                                 [](const BenchRatio* ratio) { return ratio->goal && ratio->met; });
  if (goals == 0) return {};
  const bool all = met == goals;
  const Markup verdict =
      Element("span", {{"class", all ? "verdict met" : "verdict missed"}},
              (all ? "✓ " : "✗ ") + std::to_string(met) + " of " + std::to_string(goals) + " met");
  return {{Markup(kind.title) + Element("small", {}, kind.meaning)},
          {verdict, all ? "met" : "missed"},
          {MissedList(index, ratios), "text wrap"}};
}

}  // namespace

html::Markup OverallTable(const BenchIndex& index) {
  html::Table table{"overall",
                    "How many times faster the fastest of Sweepstake is than the fastest peer, by "
                    "the median frame.",
                    {{{"Objects"},
                      {"Best of ours", "text"},
                      {"Than the peers that ran"},
                      {"By the mean"},
                      {"Than published ones"}}},
                    {}};
  for (const SceneCells& scene : index.scenes()) {
    html::TableGroup group{SceneTitle(index.report(), index.report().cells[scene.cells.front()]),
                           {}};
    for (const size_t cell : scene.cells) {
      for (const uint32_t thread_count : index.thread_counts()) {
        auto row = OverallRow(index, cell, thread_count);
        if (!row.empty()) group.rows.push_back(std::move(row));
      }
    }
    if (!group.rows.empty()) table.groups.push_back(std::move(group));
  }
  return DrawTable(table);
}

html::Markup FastestTable(const BenchIndex& index) {
  html::Table table{"fastest",
                    "The fastest of each scene and number of objects, by the median frame.",
                    {{{"Objects"}, {"Fastest", "text"}, {"Milliseconds"}, {"Pairs per frame"}}},
                    {}};
  for (const SceneCells& scene : index.scenes()) {
    html::TableGroup group{SceneTitle(index.report(), index.report().cells[scene.cells.front()]),
                           {}};
    for (const size_t cell : scene.cells) {
      const BenchRow* row = index.Fastest(cell);
      if (row == nullptr) continue;
      group.rows.push_back({{Grouped(index.report().cells[cell].object_count)},
                            {ContestantTitle(row->name, row->thread_count), "text"},
                            {Milliseconds(row->ms_median)},
                            {html::GroupedWhole(row->pairs_mean)}});
    }
    if (!group.rows.empty()) table.groups.push_back(std::move(group));
  }
  return DrawTable(table);
}

html::Markup GoalsTable(const BenchIndex& index) {
  html::Table table{"goals",
                    "The goals that this run can judge.",
                    {{{"Goal"}, {"Met"}, {"Missed", "text"}}},
                    {{{}, {}}}};
  for (const GoalKind& kind : kGoalKinds) {
    if (auto row = GoalRow(index, kind); !row.empty()) {
      table.groups.front().rows.push_back(std::move(row));
    }
  }
  return table.groups.front().rows.empty() ? Markup() : DrawTable(table);
}

html::Markup FamilyTable(const BenchIndex& index) {
  const auto ratios = RatiosOf(index.report(), RatioKind::kFamily);
  html::Table table{"families",
                    "How many times faster each of our backends is than peers of its family, by "
                    "the median frame.",
                    CellHead(index, "Backend, and compared with"),
                    {}};
  std::string ours;
  for (const FamilyLine& line : FamilyLines(ratios)) {
    const std::string title = ContestantTitle(line.ours, line.thread_count);
    if (title != ours) table.groups.push_back({title, {}});
    ours = title;
    table.groups.back().rows.push_back(FamilyRow(index, ratios, line));
  }
  return DrawTable(table);
}

}  // namespace sweepstake::cli
