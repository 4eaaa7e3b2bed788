#include "engine_client/cli/html/small_multiples.h"

#include <algorithm>
#include <cmath>

#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/html/linear_axis.h"

namespace sweepstake::cli::html {
namespace {

constexpr double kWidth = 250;
constexpr double kHeight = 150;
constexpr double kLeft = 36;
constexpr double kRight = 8;
constexpr double kTop = 8;
constexpr double kBottom = 22;
constexpr size_t kMostXTicks = 5;
constexpr size_t kMostYTicks = 4;

bool IsDrawn(const PanelPoint& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

LinearAxis AxisOf(const SmallMultiples& chart, double PanelPoint::*which) {
  double low = 0, high = 0;
  bool any = false;
  for (const Panel& panel : chart.panels) {
    for (const PanelLine& line : panel.lines) {
      for (const PanelPoint& point : line.points) {
        if (!IsDrawn(point)) continue;
        low = any ? std::min(low, point.*which) : point.*which;
        high = any ? std::max(high, point.*which) : point.*which;
        any = true;
      }
    }
  }
  return {low, high};
}

class PanelPicture {
 public:
  PanelPicture(const SmallMultiples& chart, const LinearAxis& x_axis, const LinearAxis& y_axis)
      : chart_(chart), x_axis_(x_axis), y_axis_(y_axis) {}

  Markup Draw(const Panel& panel) const {
    Markup lines;
    for (const PanelLine& line : panel.lines) {
      if (!line.strong) lines += Line(line);
    }
    for (const PanelLine& line : panel.lines) {
      if (line.strong) lines += Line(line) + Name(line);
    }
    const Markup svg = Element(
        "svg", {{"viewBox", "0 0 " + Pixels(kWidth) + " " + Pixels(kHeight)}, {"role", "img"}},
        Element("title", {}, panel.title + ": " + chart_.y_label + " against " + chart_.x_label) +
            Element("desc", {}, panel.note) + Grid() + lines);
    return Element("div", {{"class", "panel"}},
                   Element("p", {},
                           Element("b", {}, panel.title) + " " +
                               Element("span", {{"class", "soft"}}, panel.note)) +
                       svg);
  }

 private:
  double X(double value) const {
    return kLeft + x_axis_.Position(value) * (kWidth - kLeft - kRight);
  }
  double Y(double value) const {
    return kHeight - kBottom - y_axis_.Position(value) * (kHeight - kTop - kBottom);
  }

  Markup Grid() const {
    Markup grid;
    for (const double tick : y_axis_.Ticks(kMostYTicks)) {
      grid += SvgLine(kLeft, Y(tick), kWidth - kRight, Y(tick), "grid faint");
      grid += SvgText(kLeft - 5, Y(tick) + 4, "end", "tick", y_axis_.Text(tick, kMostYTicks));
    }
    for (const double tick : x_axis_.Ticks(kMostXTicks)) {
      grid += SvgText(X(tick), kHeight - 6, "middle", "tick", x_axis_.Text(tick, kMostXTicks));
    }
    return grid;
  }

  Markup Line(const PanelLine& line) const {
    std::string path;
    for (const PanelPoint& point : line.points) {
      if (!IsDrawn(point)) continue;
      path += (path.empty() ? "M" : "L") + Pixels(X(point.x)) + " " + Pixels(Y(point.y));
    }
    if (path.empty()) return {};
    return Element(
        "path",
        {{"class", "trend " + AreaClass(line.kind) + (line.strong ? " strong" : "")}, {"d", path}});
  }

  // Above the line's end, or below where it would leave the panel.
  Markup Name(const PanelLine& line) const {
    if (line.points.empty() || !IsDrawn(line.points.back())) return {};
    const double y = Y(line.points.back().y);
    return SvgText(kWidth - kRight, y < kTop + 16 ? y + 15 : y - 6, "end", "trend-name",
                   chart_.kinds[line.kind]);
  }

  const SmallMultiples& chart_;
  const LinearAxis& x_axis_;
  const LinearAxis& y_axis_;
};

}  // namespace

Markup DrawSmallMultiples(const SmallMultiples& chart) {
  const LinearAxis x_axis = AxisOf(chart, &PanelPoint::x);
  const LinearAxis y_axis = AxisOf(chart, &PanelPoint::y);
  const PanelPicture picture(chart, x_axis, y_axis);
  Markup panels;
  for (const Panel& panel : chart.panels) panels += picture.Draw(panel);
  Markup caption = Element("strong", {}, chart.title);
  if (!chart.note.empty()) caption += Element("span", {}, chart.note);
  return Element(
      "figure", {{"class", "multiples"}, {"id", chart.id}},
      Element("figcaption", {}, caption) + Element("div", {{"class", "panels"}}, panels));
}

}  // namespace sweepstake::cli::html
