// Many small line charts with common axes and one legend: the same thing again and again, to be
// compared at a glance. Linear axes. Pure function, safe from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct PanelPoint {
  double x = 0;
  double y = 0;
};

struct PanelLine {
  size_t kind = 0;
  bool strong = false;  // drawn thicker, with its kind's name at the end
  std::vector<PanelPoint> points;
};

struct Panel {
  std::string title;
  std::string note;  // below the title; may be empty
  std::vector<PanelLine> lines;
};

struct SmallMultiples {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::string x_label;
  std::string y_label;
  std::vector<std::string> kinds;
  std::vector<Panel> panels;
};

// Points that are not finite are left out; without any there are empty panels.
Markup DrawSmallMultiples(const SmallMultiples& chart);

}  // namespace sweepstake::cli::html
