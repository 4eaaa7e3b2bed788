// The tables of what was compared with what: made of the report's ratios.
#include <algorithm>
#include <array>

#include "engine_client/cli/bench_html_columns.h"
#include "engine_client/cli/bench_html_tables.h"
#include "engine_client/cli/bench_html_words.h"
#include "engine_client/cli/html/numbers.h"
#include "engine_client/cli/html/table.h"

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
  if (row != nullptr) {
    text += Element(
        "small", {},
        Milliseconds(row->ms_median) + " ms" +
            (row->note.empty() ? "" : " · " + std::to_string(row->frame_count) + " frames"));
  }
  return text;
}

Markup PeerName(const BenchIndex& index, const BenchRatio& ratio) {
  // Against several threads of ours the peer may have had several, too.
  if (ratio.derived_through.empty() && ratio.thread_count > 1) return ratio.other;
  if (ratio.derived_through.empty()) return WithTime(index, ratio.cell, ratio.other, 1);
  return Markup(ratio.other) +
         Element("small", {}, "not run here: by its published ratio to " + ratio.derived_through);
}

std::vector<TableCell> OverallRow(const BenchIndex& index, const BenchRatio& ratio) {
  const Markup value = Element("b", {}, Times(ratio.value));
  const Markup mean = ratio.value_mean ? Markup(Times(*ratio.value_mean)) : Markup("–");
  return {{Grouped(index.report().cells[ratio.cell].object_count)},
          {value + Verdict(ratio), VerdictClass(ratio)},
          {WithTime(index, ratio.cell, ratio.ours, ratio.thread_count), "text"},
          {PeerName(index, ratio), "text"},
          {mean}};
}

// One of our arms' comparison in one cell, for a row that belongs to the arm.
Markup FamilyEntry(const BenchRatio& ratio) {
  const std::string other = ratio.derived_through.empty()
                                ? ratio.other
                                : ratio.other + ", through " + ratio.derived_through;
  return Times(ratio.value) + Element("small", {}, other) + Verdict(ratio);
}

TableCell FamilyCell(const std::vector<const BenchRatio*>& ratios, size_t cell,
                     const BenchRatio& of) {
  TableCell entries;
  bool missed = false, judged = false;
  for (const BenchRatio* ratio : ratios) {
    if (ratio->cell != cell || ratio->ours != of.ours || ratio->thread_count != of.thread_count) {
      continue;
    }
    entries.content += Element("div", {}, FamilyEntry(*ratio));
    judged = judged || ratio->goal.has_value();
    missed = missed || !ratio->met;
  }
  if (entries.content.empty()) return NoValue();
  if (judged) entries.css_class = missed ? "missed" : "met";
  return entries;
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
                    "The fastest of Sweepstake against the fastest peer of the same run, by the "
                    "median frame.",
                    {{{"Objects"},
                      {"Times faster (goal)"},
                      {"Best of ours", "text"},
                      {"Best peer", "text"},
                      {"By the mean"}}},
                    {}};
  const auto ratios = RatiosOf(index.report(), RatioKind::kOverall);
  for (const SceneCells& scene : index.scenes()) {
    html::TableGroup group{SceneTitle(index.report(), index.report().cells[scene.cells.front()]),
                           {}};
    for (const size_t cell : scene.cells) {
      for (const BenchRatio* ratio : ratios) {
        if (ratio->cell == cell) group.rows.push_back(OverallRow(index, *ratio));
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
                    "How many times faster each of our backends is than the best peer of its "
                    "family, by the median frame; the peer stands below.",
                    CellHead(index, "Backend"),
                    {{{}, {}}}};
  std::vector<const BenchRatio*> seen;
  for (const BenchRatio* ratio : ratios) {
    const bool known = std::any_of(seen.begin(), seen.end(), [&](const BenchRatio* other) {
      return other->ours == ratio->ours && other->thread_count == ratio->thread_count;
    });
    if (known) continue;
    seen.push_back(ratio);
    std::vector<TableCell> row{
        {Element("b", {}, ContestantTitle(ratio->ours, ratio->thread_count))}};
    for (const size_t cell : index.cells()) row.push_back(FamilyCell(ratios, cell, *ratio));
    SeparateScenes(index, row);
    table.groups.front().rows.push_back(std::move(row));
  }
  return DrawTable(table);
}

}  // namespace sweepstake::cli
