#include "engine_client/cli/bench/bench_html.h"

#include <utility>

#include "engine_client/cli/bench/bench_html_charts.h"
#include "engine_client/cli/bench/bench_html_index.h"
#include "engine_client/cli/bench/bench_html_prose.h"
#include "engine_client/cli/bench/bench_html_tables.h"
#include "engine_client/cli/html/page.h"

namespace sweepstake::cli {
namespace {

using html::Markup;

bool HasRatio(const BenchReport& report, RatioKind kind) {
  for (const BenchRatio& ratio : report.ratios) {
    if (ratio.kind == kind) return true;
  }
  return false;
}

Markup Results(const BenchIndex& index) {
  const Markup table =
      HasRatio(index.report(), RatioKind::kOverall) ? OverallTable(index) : FastestTable(index);
  return Headline(index) + table + Warnings(index.report());
}

Markup RawRows(const BenchIndex& index, const std::string& json) {
  return html::EmbedRows("bench-json", json) +
         html::Element("details", {},
                       html::Element("summary", {}, "Show all rows") + RowTable(index));
}

}  // namespace

std::string BenchHtml(const BenchReport& report, const std::string& command_line,
                      const std::string& json) {
  const BenchIndex index(report);
  html::Page page{"Sweepstake bench", Introduction(report), {}};
  const auto add = [&](const char* id, const char* heading, Markup body) {
    if (!body.empty()) page.sections.push_back({id, heading, std::move(body)});
  };
  add("results", "Results", Results(index));
  add("judged", "Goals", GoalsTable(index));
  add("time", "Time against objects", TimeCharts(index) + TimeTable(index));
  if (HasRatio(report, RatioKind::kFamily)) {
    add("by-family", "Against the same family", FamilyTable(index));
  }
  add("per-object", "Time per object", GrowthTable(index));
  add("steady", "Steady frames", SpikeTable(index));
  if (index.thread_counts().size() > 1) add("scaling", "Threads", ThreadTable(index));
  add("work", "AABB checks", CheckTable(index));
  add("held", "Memory", MemoryTable(index));
  add("machine", "Machine and versions", MachineList(report, command_line));
  add("method", "How it was measured", Method(report));
  add("terms", "What the words mean", Terms());
  add("raw", "All rows", RawRows(index, json));
  return WritePage(page);
}

}  // namespace sweepstake::cli
