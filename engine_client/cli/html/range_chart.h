// A chart with a row per thing: a dot at its value on a logarithmic axis, and a bar from its least
// to its largest. For comparisons at one point, where a line chart would have no lines. Pure
// function, safe from any thread. Rows whose value has no place on a logarithmic axis are left out.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct RangeRow {
  std::string name;
  SeriesStyle style;
  double low = 0;
  double value = 0;
  double high = 0;
  std::string value_text;  // at the right edge
  std::string text;        // what is said of it on hover and focus
};

struct RangeChart {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::string x_label;
  std::vector<RangeRow> rows;  // from top to bottom
};

Markup DrawRangeChart(const RangeChart& chart);

}  // namespace sweepstake::cli::html
