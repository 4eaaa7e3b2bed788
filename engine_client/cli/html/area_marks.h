// Areas of a kind, as timelines and stacked bars have: filled in one of eight colours that the
// colour-blind tell apart (Okabe and Ito's, without their yellow but for the last), with the kind's
// name on it where there is room, and a legend beside. Pure functions, safe from any thread.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

inline constexpr size_t kAreaCount = 8;

// "a3"; indices beyond kAreaCount wrap around.
std::string AreaClass(size_t kind);

// A rectangle with `text` on it where it fits, and `title` said on hover. Widths below half a unit
// are drawn half a unit wide.
struct Area {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
  size_t kind = 0;
  std::string text;
  std::string title;
  bool faint = false;
};
Markup DrawArea(const Area& area);

// A chip with a name, for tables and legends.
Markup AreaChip(size_t kind, const std::string& name);
Markup AreaLegend(const std::vector<std::string>& kinds);

// A figure with caption, a picture of this size, and what stands below it. `summary` says in words
// what the picture shows.
struct AreaFigure {
  std::string id;  // one on the page
  std::string title;
  std::string note;  // below the title; may be empty
  std::string summary;
  double width = 0;
  double height = 0;
};
Markup DrawFigure(const AreaFigure& figure, const Markup& picture, const Markup& below);

}  // namespace sweepstake::cli::html
