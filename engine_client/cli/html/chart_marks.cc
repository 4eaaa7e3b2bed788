#include "engine_client/cli/html/chart_marks.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace sweepstake::cli::html {
namespace {

// Corners of the mark with this index on the unit circle, and by how many eighths of a turn it is
// rotated; 0 corners is a circle, a negative count a star.
struct Shape {
  int corners;
  double turn_eighths;
};
constexpr std::array<Shape, kColourCount> kShapes{{
    {0, 0},   // circle
    {4, 1},   // square
    {3, 6},   // triangle
    {4, 0},   // diamond
    {3, 2},   // triangle, point down
    {5, 6},   // pentagon
    {-4, 1},  // star of four rays, upright ones between
    {6, 0},   // hexagon
}};

// A star has an inner corner between every two.
std::string CornerPath(const Shape& shape, double x, double y, double radius) {
  const int corners = shape.corners < 0 ? -2 * shape.corners : shape.corners;
  std::string path;
  for (int i = 0; i < corners; ++i) {
    const double angle =
        std::numbers::pi * (shape.turn_eighths / 4 + 2.0 * i / static_cast<double>(corners));
    const double distance = radius * (shape.corners < 0 && i % 2 == 1 ? 0.45 : 1.2);
    path += (i == 0 ? "M" : "L") + Pixels(x + distance * std::cos(angle)) + " " +
            Pixels(y + distance * std::sin(angle));
  }
  return path + "Z";
}

}  // namespace

std::string Pixels(double value) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

std::string StyleClass(const SeriesStyle& style) {
  return "c" + std::to_string(style.colour % kColourCount) + (style.solid ? " solid" : " dashed");
}

Markup Mark(const SeriesStyle& style, double x, double y, double radius) {
  const Shape& shape = kShapes[style.colour % kColourCount];
  if (shape.corners == 0) {
    return Element(
        "circle", {{"class", "mark"}, {"cx", Pixels(x)}, {"cy", Pixels(y)}, {"r", Pixels(radius)}});
  }
  return Element("path", {{"class", "mark"}, {"d", CornerPath(shape, x, y, radius)}});
}

Markup Swatch(const SeriesStyle& style) {
  return Element("svg",
                 {{"class", "swatch " + StyleClass(style)},
                  {"viewBox", "0 0 30 12"},
                  {"width", "30"},
                  {"height", "12"},
                  {"aria-hidden", "true"}},
                 SvgLine(1, 6, 29, 6, "line") + Mark(style, 15, 6, 4));
}

Markup SvgText(double x, double y, const std::string& anchor, const std::string& css_class,
               const std::string& text) {
  return Element(
      "text", {{"x", Pixels(x)}, {"y", Pixels(y)}, {"text-anchor", anchor}, {"class", css_class}},
      text);
}

Markup SvgLine(double x1, double y1, double x2, double y2, const std::string& css_class) {
  return Element("line", {{"class", css_class},
                          {"x1", Pixels(x1)},
                          {"y1", Pixels(y1)},
                          {"x2", Pixels(x2)},
                          {"y2", Pixels(y2)}});
}

}  // namespace sweepstake::cli::html
