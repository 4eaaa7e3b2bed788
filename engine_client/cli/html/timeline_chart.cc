#include "engine_client/cli/html/timeline_chart.h"

#include <cmath>
#include <set>

#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/html/linear_axis.h"

namespace sweepstake::cli::html {
namespace {

constexpr double kWidth = 900;
constexpr double kLeft = 120;
constexpr double kRight = 12;
constexpr double kLaneHeight = 27;
constexpr double kBarHeight = 18;
constexpr double kTickHeight = 4;
constexpr double kTop = 4;
constexpr double kBottom = 40;
constexpr size_t kMostTicks = 10;

class Picture {
 public:
  explicit Picture(const TimelineChart& chart)
      : chart_(chart),
        axis_(0, chart.end),
        bottom_(kTop + kLaneHeight * static_cast<double>(chart.lanes.size())) {}

  double height() const { return bottom_ + kBottom; }

  Markup Draw() const {
    Markup picture = Grid();
    double y = kTop;
    for (const TimelineLane& lane : chart_.lanes) {
      picture += Lane(lane, y);
      y += kLaneHeight;
    }
    return picture;
  }

 private:
  double X(double time) const { return kLeft + axis_.Position(time) * (kWidth - kLeft - kRight); }

  Markup Grid() const {
    Markup grid;
    for (const double tick : axis_.Ticks(kMostTicks)) {
      grid += SvgLine(X(tick), kTop, X(tick), bottom_, "grid faint");
      grid += SvgText(X(tick), bottom_ + 16, "middle", "tick", axis_.Text(tick, kMostTicks));
    }
    return grid +
           SvgText((kLeft + kWidth - kRight) / 2, bottom_ + 34, "middle", "axis", chart_.x_label);
  }

  Markup Lane(const TimelineLane& lane, double y) const {
    Markup drawn = SvgText(kLeft - 10, y + kBarHeight / 2 + 4, "end", "row-name", lane.name);
    for (const TimelineStretch& stretch : lane.stretches) {
      drawn += DrawArea({.x = X(stretch.from),
                         .y = y,
                         .width = X(stretch.to) - X(stretch.from),
                         .height = kBarHeight,
                         .kind = stretch.kind,
                         .text = chart_.kinds[stretch.kind],
                         .title = lane.name + ": " + stretch.text,
                         .faint = stretch.faint});
    }
    return drawn + Strokes(lane, y + kBarHeight + 2) + Crosses(lane, y + kBarHeight / 2);
  }

  // One path; those of one unit of the picture are one stroke.
  Markup Strokes(const TimelineLane& lane, double y) const {
    std::set<long> places;
    for (const double tick : lane.ticks) places.insert(std::lround(X(tick)));
    if (places.empty()) return {};
    std::string path;
    for (const long x : places) {
      path += "M" + std::to_string(x) + " " + Pixels(y) + "v" + Pixels(kTickHeight);
    }
    return Element("path", {{"class", "strokes"}, {"d", path}});
  }

  Markup Crosses(const TimelineLane& lane, double y) const {
    Markup crosses;
    for (const TimelineMark& mark : lane.marks) {
      const double x = X(mark.at), arm = 5;
      std::string path = "M" + Pixels(x - arm) + " " + Pixels(y - arm);
      path += "L" + Pixels(x + arm) + " " + Pixels(y + arm) + "M" + Pixels(x - arm) + " " +
              Pixels(y + arm) + "L" + Pixels(x + arm) + " " + Pixels(y - arm);
      crosses += Element(
          "g", {{"class", "cross"}},
          Element("title", {}, lane.name + ": " + mark.text) + Element("path", {{"d", path}}));
    }
    return crosses;
  }

  const TimelineChart& chart_;
  LinearAxis axis_;
  double bottom_;
};

}  // namespace

Markup DrawTimelineChart(const TimelineChart& chart) {
  const Picture picture(chart);
  return DrawFigure({.id = chart.id,
                     .title = chart.title,
                     .note = chart.note,
                     .summary = "A lane per row along the time; each stretch is named on hover.",
                     .width = kWidth,
                     .height = picture.height()},
                    picture.Draw(), {});
}

}  // namespace sweepstake::cli::html
