// A chart with a bar per thing, each divided into shares of a whole by kind. Pure function, safe
// from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

struct StackedRow {
  std::string name;
  std::string group;           // rows of one group follow one another, below its name
  std::vector<double> values;  // by kind; >= 0, of any sum above 0
};

struct StackedBars {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::vector<std::string> kinds;
  std::vector<StackedRow> rows;  // from top to bottom
};

Markup DrawStackedBars(const StackedBars& chart);

}  // namespace sweepstake::cli::html
