// A chart with a lane per thing over a common time: what it was when, as coloured stretches; below
// each a row of ticks, and marks on it. Pure function, safe from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct TimelineStretch {
  double from = 0;
  double to = 0;
  size_t kind = 0;
  std::string text;    // what is said of it on hover
  bool faint = false;  // told apart from the others, as what came before the measuring
};

struct TimelineMark {
  double at = 0;
  std::string text;
};

struct TimelineLane {
  std::string name;
  std::vector<TimelineStretch> stretches;
  std::vector<double> ticks;        // small strokes below the lane
  std::vector<TimelineMark> marks;  // crosses on it
};

struct TimelineChart {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::string x_label;
  double end = 0;  // of the time, which begins at 0; > 0
  std::vector<std::string> kinds;
  std::vector<TimelineLane> lanes;  // from top to bottom
};

Markup DrawTimelineChart(const TimelineChart& chart);

}  // namespace sweepstake::cli::html
