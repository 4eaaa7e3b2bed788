#include "engine_client/cli/html/range_chart.h"

#include <algorithm>

#include "engine_client/cli/html/log_axis.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli::html {
namespace {

constexpr double kWidth = 900;
constexpr double kLeastLeft = 190;  // for the rows' names; wider where they are
constexpr double kMostLeft = 330;
constexpr double kNameLetterWidth = 7.4;  // bold, generously
constexpr double kRight = 100;
constexpr double kTop = 6;
constexpr double kRowHeight = 24;
constexpr double kBottom = 48;

double LeftOf(const RangeChart& chart) {
  size_t most = 0;
  for (const RangeRow& row : chart.rows) most = std::max(most, LetterCount(row.name));
  return std::clamp(kNameLetterWidth * static_cast<double>(most) + 16, kLeastLeft, kMostLeft);
}

LogAxis AxisOf(const RangeChart& chart) {
  std::vector<double> values;
  for (const RangeRow& row : chart.rows)
    values.insert(values.end(), {row.low, row.value, row.high});
  return {values, 1.25};
}

double X(const LogAxis& axis, double left, double value) {
  return left + axis.Position(value) * (kWidth - left - kRight);
}

Markup Grid(const RangeChart& chart, const LogAxis& axis, double left, double bottom) {
  Markup grid;
  for (const Tick& tick : axis.Ticks()) {
    const double x = X(axis, left, tick.value);
    grid += SvgLine(x, kTop, x, bottom, tick.labelled ? "grid" : "grid faint");
    if (tick.labelled)
      grid += SvgText(x, bottom + 18, "middle", "tick", Significant(tick.value, 1));
  }
  return grid + SvgText((left + kWidth - kRight) / 2, bottom + 40, "middle", "axis", chart.x_label);
}

Markup Row(const RangeRow& row, const LogAxis& axis, double left, double y) {
  Markup bar;
  if (IsOnLogAxis(row.low) && IsOnLogAxis(row.high)) {
    bar = SvgLine(X(axis, left, row.low), y, X(axis, left, row.high), y, "range");
  }
  const double x = X(axis, left, row.value);
  const Markup point =
      Element("g",
              {{"class", "point"},
               {"tabindex", "-1"},
               {"data-x", Pixels(x)},
               {"data-y", Pixels(y)},
               {"data-text", row.name + "\n" + row.text}},
              Element("title", {}, row.name + ": " + row.text) + Mark(row.style, x, y, 5));
  return Element("g", {{"class", "series " + StyleClass(row.style)}},
                 SvgText(left - 12, y + 4, "end", "row-name", row.name) + bar + point +
                     SvgText(kWidth - kRight + 12, y + 4, "start", "row-value", row.value_text));
}

}  // namespace

Markup DrawRangeChart(const RangeChart& chart) {
  const LogAxis axis = AxisOf(chart);
  const double left = LeftOf(chart);
  const auto placed = std::count_if(chart.rows.begin(), chart.rows.end(),
                                    [](const RangeRow& row) { return IsOnLogAxis(row.value); });
  const double bottom = kTop + kRowHeight * static_cast<double>(placed);
  Markup picture = Grid(chart, axis, left, bottom);
  double y = kTop + kRowHeight / 2;
  for (const RangeRow& row : chart.rows) {
    if (!IsOnLogAxis(row.value)) continue;
    picture += Row(row, axis, left, y);
    y += kRowHeight;
  }
  Markup caption = Element("strong", {}, chart.title);
  if (!chart.note.empty()) caption += Element("span", {}, chart.note);
  const Markup svg = Element("svg",
                             {{"viewBox", "0 0 " + Pixels(kWidth) + " " + Pixels(bottom + kBottom)},
                              {"role", "img"},
                              {"aria-label", chart.title + "; the tables below hold the values"},
                              {"tabindex", "0"}},
                             picture);
  return Element("figure", {{"class", "chart ranges"}, {"id", chart.id}},
                 Element("figcaption", {}, caption) + Element("div", {{"class", "plot"}}, svg));
}

}  // namespace sweepstake::cli::html
