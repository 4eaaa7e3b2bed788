#include "engine_client/cli/bench/bench_html_tables.h"

#include <algorithm>
#include <functional>

#include "engine_client/cli/bench/bench_html_columns.h"
#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using html::Compact;
using html::Element;
using html::Markup;
using html::TableCell;

// What stands in a contestant's row at a cell that it measured.
using CellContent = std::function<TableCell(const BenchContestant&, const BenchRow&)>;

enum class Shown { kAll, kOurs };

Markup Small(const Markup& content) { return Element("small", {}, content); }

TableCell ContestantName(const BenchContestant& contestant) {
  Markup name = html::Swatch(contestant.style) + " " +
                ContestantTitle(contestant.name, contestant.thread_count);
  if (contestant.kind == ContestantKind::kPeer)
    return {name + " " + Element("span", {{"class", "none"}}, "peer")};
  return {Element("b", {}, name)};
}

Markup ContestantTable(const BenchIndex& index, const std::string& id, const std::string& caption,
                       Shown shown, const CellContent& content) {
  html::Table table{id, caption, CellHead(index, "Family and contestant"), {}};
  for (const std::string& family : index.families()) {
    html::TableGroup group{FamilyTitle(family), {}};
    for (const BenchContestant& contestant : index.contestants()) {
      if (contestant.family != family) continue;
      if (shown == Shown::kOurs && contestant.kind == ContestantKind::kPeer) continue;
      std::vector<TableCell> row{ContestantName(contestant)};
      for (const size_t cell : index.cells()) {
        const BenchRow* found = contestant.rows[cell];
        row.push_back(found == nullptr ? NoValue() : content(contestant, *found));
      }
      SeparateScenes(index, row);
      group.rows.push_back(std::move(row));
    }
    if (!group.rows.empty()) table.groups.push_back(std::move(group));
  }
  return DrawTable(table);
}

const BenchRatio* FindRatio(const BenchReport& report, RatioKind kind, const BenchRow& row) {
  for (const BenchRatio& ratio : report.ratios) {
    if (ratio.kind == kind && ratio.cell == row.cell && ratio.ours == row.name &&
        ratio.thread_count == row.thread_count) {
      return &ratio;
    }
  }
  return nullptr;
}

// `content` with what a goal of this kind says of `row`.
TableCell Judged(const BenchReport& report, RatioKind kind, const BenchRow& row, Markup content) {
  const BenchRatio* ratio =
      row.kind == ContestantKind::kArm ? FindRatio(report, kind, row) : nullptr;
  if (ratio == nullptr) return {std::move(content)};
  return {content + Verdict(*ratio), VerdictClass(*ratio)};
}

}  // namespace

html::Markup TimeTable(const BenchIndex& index) {
  return ContestantTable(
      index, "times",
      "Milliseconds per frame, median; below it how many times the fastest of the column takes. "
      "★ is the fastest.",
      Shown::kAll, [&](const BenchContestant&, const BenchRow& row) -> TableCell {
        const double fastest = index.Fastest(row.cell)->ms_median;
        Markup content = Milliseconds(row.ms_median);
        if (row.ms_median == fastest) content = Markup("★ ") + content;
        content += Small(Times(row.ms_median / fastest));
        if (!row.difference.empty()) {
          content += Element("small", {{"class", "verdict missed"}}, "✗ wrong pairs");
        }
        return {content, row.ms_median == fastest ? "best" : ""};
      });
}

html::Markup GrowthTable(const BenchIndex& index) {
  return ContestantTable(index, "growth",
                         "Nanoseconds per object and frame: a number that stays the same along a "
                         "row is linear growth.",
                         Shown::kAll, [&](const BenchContestant&, const BenchRow& row) {
                           const double objects = index.report().cells[row.cell].object_count;
                           const BenchRatio* ratio =
                               FindRatio(index.report(), RatioKind::kGrowth, row);
                           Markup content = html::Significant(row.ms_median * 1e6 / objects, 3);
                           if (ratio != nullptr && row.kind == ContestantKind::kArm) {
                             content += Small(Times(ratio->value) + " that at " + ratio->other);
                           }
                           return Judged(index.report(), RatioKind::kGrowth, row, content);
                         });
}

html::Markup SpikeTable(const BenchIndex& index) {
  return ContestantTable(
      index, "spikes",
      "The slowest frame but one in a hundred (p99) divided by the median: 1× is a steady frame "
      "time. Below it the p99 in milliseconds.",
      Shown::kAll, [&](const BenchContestant&, const BenchRow& row) {
        const Markup content =
            Markup(Times(row.ms_p99 / row.ms_median)) + Small(Milliseconds(row.ms_p99) + " ms");
        return Judged(index.report(), RatioKind::kSpike, row, content);
      });
}

html::Markup CheckTable(const BenchIndex& index) {
  return ContestantTable(
      index, "checks",
      "Comparisons of two boxes per frame, and below it how many for each pair found. Peers do not "
      "count theirs.",
      Shown::kOurs, [](const BenchContestant&, const BenchRow& row) -> TableCell {
        if (!row.aabb_checks_mean) return NoValue();
        return {Markup(Compact(*row.aabb_checks_mean)) +
                Small(Compact(*row.aabb_checks_mean / row.pairs_mean) + " per pair")};
      });
}

html::Markup MemoryTable(const BenchIndex& index) {
  return ContestantTable(
      index, "memory",
      "The most that a backend held in a measured frame, with the buffer of the pairs; below it "
      "the "
      "backend alone, per object.",
      Shown::kOurs, [&](const BenchContestant&, const BenchRow& row) -> TableCell {
        if (!row.bytes) return NoValue();
        const auto own = static_cast<double>(*row.bytes);
        const double objects = index.report().cells[row.cell].object_count;
        const double all = row.bytes_with_pairs ? static_cast<double>(*row.bytes_with_pairs) : own;
        return Judged(index.report(), RatioKind::kMemory, row,
                      Markup(html::Bytes(all)) + Small(html::Bytes(own / objects) + " per object"));
      });
}

html::Markup ThreadTable(const BenchIndex& index) {
  html::Table table{"threads",
                    "How many times faster with several threads than with the fewest, by the "
                    "median; below it the milliseconds per frame.",
                    CellHead(index, "Backend and threads"),
                    {{{}, {}}}};
  for (const BenchContestant& contestant : index.contestants()) {
    if (contestant.kind == ContestantKind::kPeer) continue;
    for (const uint32_t threads : index.thread_counts()) {
      if (threads == contestant.thread_count) continue;
      std::vector<TableCell> row{{Element(
          "b", {},
          html::Swatch(contestant.style) + " " + ContestantTitle(contestant.name, threads))}};
      for (const size_t cell : index.cells()) {
        const BenchRow* several = index.Find(cell, contestant.name, threads);
        const BenchRow* fewest = contestant.rows[cell];
        if (several == nullptr || fewest == nullptr) {
          row.push_back(NoValue());
          continue;
        }
        row.push_back(Judged(index.report(), RatioKind::kThreads, *several,
                             Markup(Times(fewest->ms_median / several->ms_median)) +
                                 Small(Milliseconds(several->ms_median) + " ms")));
      }
      SeparateScenes(index, row);
      table.groups.front().rows.push_back(std::move(row));
    }
  }
  return DrawTable(table);
}

}  // namespace sweepstake::cli
