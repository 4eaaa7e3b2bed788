#include "engine_client/cli/html/stacked_bars.h"

#include <numeric>

#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli::html {
namespace {

constexpr double kWidth = 900;
constexpr double kLeft = 190;
constexpr double kRight = 16;
constexpr double kRowHeight = 26;
constexpr double kBarHeight = 20;
constexpr double kGroupHeight = 26;
constexpr double kBottom = 26;
// Shares from which a bar's part has its figure beside the name.
constexpr double kFigureShare = 0.12;

double X(double share) { return kLeft + share * (kWidth - kLeft - kRight); }

std::string Percent(double share) { return Significant(100 * share, 3) + " %"; }

Markup Bar(const StackedBars& chart, const StackedRow& row, double y) {
  const double sum = std::accumulate(row.values.begin(), row.values.end(), 0.0);
  Markup bar = SvgText(kLeft - 10, y + kBarHeight / 2 + 4, "end", "row-name", row.name);
  double from = 0;
  for (size_t kind = 0; kind < row.values.size() && sum > 0; ++kind) {
    const double share = row.values[kind] / sum;
    if (share <= 0) continue;
    const std::string& name = chart.kinds[kind];
    bar += DrawArea({.x = X(from),
                     .y = y,
                     .width = X(from + share) - X(from),
                     .height = kBarHeight,
                     .kind = kind,
                     .text = share < kFigureShare ? name : name + " " + Percent(share),
                     .title = row.name + ": " + name + " " + Percent(share)});
    from += share;
  }
  return bar;
}

Markup Grid(double bottom) {
  Markup grid;
  for (int percent = 0; percent <= 100; percent += 20) {
    const double x = X(percent / 100.0);
    grid += SvgLine(x, 0, x, bottom, "grid faint");
    grid += SvgText(x, bottom + 17, percent == 100 ? "end" : "middle", "tick",
                    std::to_string(percent) + " %");
  }
  return grid;
}

}  // namespace

Markup DrawStackedBars(const StackedBars& chart) {
  Markup bars;
  double y = 4;
  std::string group;
  for (const StackedRow& row : chart.rows) {
    if (row.group != group) {
      group = row.group;
      bars += SvgText(0, y + kGroupHeight / 2 + 4, "start", "axis", group);
      y += kGroupHeight;
    }
    bars += Bar(chart, row, y);
    y += kRowHeight;
  }
  return DrawFigure({.id = chart.id,
                     .title = chart.title,
                     .note = chart.note,
                     .summary = "A bar per row, divided into shares by kind; hovering says each.",
                     .width = kWidth,
                     .height = y + kBottom},
                    Grid(y) + bars, AreaLegend(chart.kinds));
}

}  // namespace sweepstake::cli::html
