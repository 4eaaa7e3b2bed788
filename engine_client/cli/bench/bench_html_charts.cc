#include "engine_client/cli/bench/bench_html_charts.h"

#include <algorithm>

#include "engine_client/cli/bench/bench_html_words.h"
#include "engine_client/cli/html/line_chart.h"
#include "engine_client/cli/html/range_chart.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

constexpr const char* kTimeLabel = "Milliseconds per frame, median";

std::string Described(const BenchIndex& index, const BenchRow& row) {
  const double fastest = index.Fastest(row.cell)->ms_median;
  const std::string rank =
      row.ms_median > fastest ? Times(row.ms_median / fastest) + " the fastest" : "the fastest";
  return html::Grouped(index.report().cells[row.cell].object_count) +
         " objects: " + Milliseconds(row.ms_median) + " ms (" + rank + ")\nmin " +
         Milliseconds(row.ms_min) + " ms · p99 " + Milliseconds(row.ms_p99) + " ms";
}

html::ChartSeries SeriesOf(const BenchIndex& index, const SceneCells& scene,
                           const BenchContestant& contestant) {
  html::ChartSeries series{ContestantTitle(contestant.name, contestant.thread_count),
                           FamilyTitle(contestant.family),
                           contestant.style,
                           {}};
  for (const size_t cell : scene.cells) {
    const BenchRow* row = contestant.rows[cell];
    if (row == nullptr) continue;
    series.points.push_back({static_cast<double>(index.report().cells[cell].object_count),
                             row->ms_median, Described(index, *row)});
  }
  return series;
}

html::Markup GrowthChart(const BenchIndex& index, const SceneCells& scene, const std::string& id) {
  html::LineChart chart{id,
                        SceneTitle(index.report(), index.report().cells[scene.cells.front()]),
                        SceneNote(scene.name),
                        "Objects",
                        kTimeLabel,
                        {}};
  for (const BenchContestant& contestant : index.contestants()) {
    html::ChartSeries series = SeriesOf(index, scene, contestant);
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return DrawLineChart(chart);
}

html::Markup RankingChart(const BenchIndex& index, size_t cell, const std::string& id) {
  html::RangeChart chart{id,
                         CellTitle(index.report(), cell),
                         SceneNote(index.report().cells[cell].scene),
                         "Milliseconds per frame: the mark is the median, the bar reaches from the "
                         "fastest frame to the p99",
                         {}};
  for (const BenchContestant& contestant : index.contestants()) {
    const BenchRow* row = contestant.rows[cell];
    if (row == nullptr) continue;
    chart.rows.push_back({ContestantTitle(contestant.name, contestant.thread_count),
                          contestant.style, row->ms_min, row->ms_median, row->ms_p99,
                          Milliseconds(row->ms_median) + " ms", Described(index, *row)});
  }
  std::stable_sort(
      chart.rows.begin(), chart.rows.end(),
      [](const html::RangeRow& a, const html::RangeRow& b) { return a.value < b.value; });
  return DrawRangeChart(chart);
}

}  // namespace

html::Markup TimeCharts(const BenchIndex& index) {
  html::Markup charts;
  for (size_t i = 0; i < index.scenes().size(); ++i) {
    const SceneCells& scene = index.scenes()[i];
    const std::string id = "chart-" + std::to_string(i + 1);
    charts += scene.cells.size() > 1 ? GrowthChart(index, scene, id)
                                     : RankingChart(index, scene.cells.front(), id);
  }
  return charts;
}

}  // namespace sweepstake::cli
