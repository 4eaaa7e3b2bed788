// A line chart with two logarithmic axes, as a figure with a legend whose boxes show and hide the
// lines. The picture stands by itself: names at the lines' ends, values as titles of the points;
// the page's script adds a tooltip and the arrow keys. Pure function, safe from any thread.
//
// Points that have no place on a logarithmic axis are left out.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct ChartPoint {
  double x = 0;
  double y = 0;
  std::string text;  // what is said of it on hover and focus
};

struct ChartSeries {
  std::string name;
  std::string group;  // of the legend; series of one group follow one another
  SeriesStyle style;
  std::vector<ChartPoint> points;  // x ascending
};

struct LineChart {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::string x_label;
  std::string y_label;
  // More than kMostToggles can be drawn, but not hidden.
  std::vector<ChartSeries> series;
};

inline constexpr size_t kMostToggles = 48;

Markup DrawLineChart(const LineChart& chart);

}  // namespace sweepstake::cli::html
