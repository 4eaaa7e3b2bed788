// What lines and dots look like: so that two series differ by more than colour, each has a colour,
// a shape, and is solid or dashed. Pure functions, safe from any thread.
#pragma once

#include <cstddef>
#include <string>

#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli::html {

// Colours and shapes there are; indices beyond wrap around.
inline constexpr size_t kColourCount = 8;

struct SeriesStyle {
  size_t colour = 0;  // of the page's palette, and one of as many shapes
  bool solid = true;  // a solid line and filled marks; else dashed and hollow
};

// "0.1" steps are enough for a picture.
std::string Pixels(double value);

// The classes of an element of this style: "c3 solid".
std::string StyleClass(const SeriesStyle& style);

// The mark of the style at (x, y), in SVG.
Markup Mark(const SeriesStyle& style, double x, double y, double radius);

// A short line with the mark, as a picture of its own: for legends and tables.
Markup Swatch(const SeriesStyle& style);

// Text in a picture; `anchor` as in SVG: start, middle, end.
Markup SvgText(double x, double y, const std::string& anchor, const std::string& css_class,
               const std::string& text);

// A straight line in a picture.
Markup SvgLine(double x1, double y1, double x2, double y2, const std::string& css_class);

}  // namespace sweepstake::cli::html
