// The table of all rows.
#include <optional>

#include "engine_client/cli/bench/bench_html_tables.h"
#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

using html::Grouped;
using html::Markup;
using html::TableCell;

TableCell Count(const std::optional<uint64_t>& count) {
  return count ? Grouped(*count) : Markup("–");
}

TableCell Whole(const std::optional<double>& value) {
  return value ? html::GroupedWhole(*value) : Markup("–");
}

Markup Notes(const BenchRow& row) {
  Markup notes = row.note;
  if (!row.difference.empty()) {
    notes += html::Element("span", {{"class", "verdict missed"}},
                           (row.note.empty() ? "" : "; ") + ("✗ wrong pairs: " + row.difference));
  }
  return notes;
}

std::vector<TableCell> Cells(const BenchRow& row) {
  std::vector<TableCell> cells{{row.name},
                               {FamilyTitle(row.family), "text"},
                               {Grouped(row.thread_count)},
                               {Grouped(row.frame_count)}};
  if (row.frame_count == 0) {
    cells.insert(cells.end(), 8, {"–", "none"});
  } else {
    for (const double ms : {row.ms_median, row.ms_mean, row.ms_min, row.ms_p99}) {
      cells.emplace_back(Milliseconds(ms));
    }
    cells.insert(cells.end(), {Whole(row.pairs_mean), Whole(row.aabb_checks_mean), Count(row.bytes),
                               Count(row.bytes_with_pairs)});
  }
  cells.emplace_back(Notes(row), "text");
  return cells;
}

}  // namespace

html::Markup RowTable(const BenchIndex& index) {
  const BenchReport& report = index.report();
  html::Table table{"rows",
                    "Every contestant in every scene. Times in milliseconds per frame.",
                    {{{"Contestant"},
                      {"Family", "text"},
                      {"Threads"},
                      {"Frames"},
                      {"Median"},
                      {"Mean"},
                      {"Min"},
                      {"p99"},
                      {"Pairs"},
                      {"AABB checks"},
                      {"Bytes"},
                      {"With pairs"},
                      {"Note", "text"}}},
                    {}};
  for (const size_t cell : index.cells()) {
    html::TableGroup group{CellTitle(report, cell), {}};
    for (const BenchRow& row : report.rows) {
      if (row.cell == cell) group.rows.push_back(Cells(row));
    }
    table.groups.push_back(std::move(group));
  }
  return DrawTable(table);
}

}  // namespace sweepstake::cli
