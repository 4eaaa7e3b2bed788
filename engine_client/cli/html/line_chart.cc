#include "engine_client/cli/html/line_chart.h"

#include <algorithm>
#include <set>

#include "engine_client/cli/html/log_axis.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli::html {
namespace {

// Of the picture, in its own units; names of the lines go into the right margin.
constexpr double kWidth = 900;
constexpr double kHeight = 470;
constexpr double kLeft = 64;
constexpr double kRight = 200;
constexpr double kTop = 14;
constexpr double kBottom = 52;
constexpr double kNameHeight = 15;
constexpr double kHeightPerSeries = 20;

std::vector<double> Values(const LineChart& chart, double ChartPoint::*which) {
  std::vector<double> values;
  for (const ChartSeries& series : chart.series) {
    for (const ChartPoint& point : series.points) {
      if (IsOnLogAxis(point.x) && IsOnLogAxis(point.y)) values.push_back(point.*which);
    }
  }
  return values;
}

// The name of a line at its end.
struct EndName {
  size_t series;
  double from_x, from_y;  // the line's last point
  double y;               // of the name
};

class Picture {
 public:
  explicit Picture(const LineChart& chart)
      : chart_(chart),
        x_axis_(Values(chart, &ChartPoint::x), 1.25),
        y_axis_(Values(chart, &ChartPoint::y), 1.5),
        bottom_(std::max(kHeight, kTop + kBottom +
                                      kHeightPerSeries * static_cast<double>(chart.series.size())) -
                kBottom) {}

  Markup Draw() const {
    return Element("svg",
                   {{"viewBox", "0 0 " + Pixels(kWidth) + " " + Pixels(bottom_ + kBottom)},
                    {"role", "img"},
                    {"aria-label", chart_.title + ": " + chart_.y_label + " against " +
                                       chart_.x_label + "; the tables below hold the values"},
                    {"tabindex", "0"}},
                   Grid() + Lines() + Names());
  }

 private:
  static constexpr double kPlotRight = kWidth - kRight;

  double X(double value) const { return kLeft + x_axis_.Position(value) * (kPlotRight - kLeft); }
  double Y(double value) const { return bottom_ - y_axis_.Position(value) * (bottom_ - kTop); }

  Markup Grid() const {
    Markup grid;
    for (const Tick& tick : y_axis_.Ticks()) {
      const double y = Y(tick.value);
      grid += SvgLine(kLeft, y, kPlotRight, y, tick.labelled ? "grid" : "grid faint");
      if (tick.labelled)
        grid += SvgText(kLeft - 8, y + 4, "end", "tick", Significant(tick.value, 1));
    }
    for (const double value : CountTicks()) {
      grid += SvgLine(X(value), kTop, X(value), bottom_, "grid");
      grid += SvgText(X(value), bottom_ + 19, "middle", "tick", Compact(value));
    }
    grid += SvgText((kLeft + kPlotRight) / 2, bottom_ + 42, "middle", "axis", chart_.x_label);
    const std::string middle = Pixels((kTop + bottom_) / 2);
    grid += Element("text",
                    {{"class", "axis"},
                     {"text-anchor", "middle"},
                     {"transform", "translate(15 " + middle + ") rotate(-90)"}},
                    chart_.y_label);
    return grid;
  }

  // The x values there are: a reader looks for those, not for round ones.
  std::vector<double> CountTicks() const {
    const std::vector<double> values = Values(chart_, &ChartPoint::x);
    const std::set<double> distinct(values.begin(), values.end());
    return SpacedOut(x_axis_, std::vector<double>(distinct.begin(), distinct.end()), 0.07);
  }

  Markup Lines() const {
    Markup lines;
    for (size_t i = 0; i < chart_.series.size(); ++i) {
      lines += Element("g", {{"class", GroupClass(i)}, {"data-series", std::to_string(i)}},
                       Line(chart_.series[i]));
    }
    return lines;
  }

  std::string GroupClass(size_t index) const {
    return "series k" + std::to_string(index) + " " + StyleClass(chart_.series[index].style);
  }

  Markup Line(const ChartSeries& series) const {
    std::string path;
    Markup marks;
    for (const ChartPoint& point : series.points) {
      if (!IsOnLogAxis(point.x) || !IsOnLogAxis(point.y)) continue;
      const std::string x = Pixels(X(point.x)), y = Pixels(Y(point.y));
      path.append(path.empty() ? "M" : "L").append(x).append(" ").append(y);
      marks += Element("g",
                       {{"class", "point"},
                        {"tabindex", "-1"},
                        {"data-x", x},
                        {"data-y", y},
                        {"data-text", series.name + "\n" + point.text}},
                       Element("title", {}, series.name + ": " + point.text) +
                           Mark(series.style, X(point.x), Y(point.y), 4.2));
    }
    return Element("path", {{"class", "line"}, {"d", path}}) + marks;
  }

  // One below the other, in the order of the lines' ends, each as near to its own as that allows.
  std::vector<EndName> PlacedNames() const {
    std::vector<EndName> names;
    for (size_t i = 0; i < chart_.series.size(); ++i) {
      const auto& points = chart_.series[i].points;
      const auto last = std::find_if(points.rbegin(), points.rend(), [](const ChartPoint& point) {
        return IsOnLogAxis(point.x) && IsOnLogAxis(point.y);
      });
      if (last != points.rend()) names.push_back({i, X(last->x), Y(last->y), Y(last->y)});
    }
    std::sort(names.begin(), names.end(),
              [](const EndName& a, const EndName& b) { return a.y < b.y; });
    double least = kTop + kNameHeight / 2;
    for (EndName& name : names) {
      name.y = std::max(name.y, least);
      least = name.y + kNameHeight;
    }
    double most = bottom_ - kNameHeight / 2;
    for (auto name = names.rbegin(); name != names.rend(); ++name) {
      name->y = std::min(name->y, most);
      most = name->y - kNameHeight;
    }
    return names;
  }

  Markup Names() const {
    Markup names;
    for (const EndName& name : PlacedNames()) {
      const ChartSeries& series = chart_.series[name.series];
      names += Element("g", {{"class", GroupClass(name.series) + " name"}},
                       SvgLine(name.from_x + 7, name.from_y, kPlotRight + 12, name.y, "leader") +
                           SvgText(kPlotRight + 16, name.y + 4, "start", "end-name", series.name));
    }
    return names;
  }

  const LineChart& chart_;
  LogAxis x_axis_;
  LogAxis y_axis_;
  double bottom_;  // of the plot: long lists of names make it higher
};

Markup LegendEntry(const ChartSeries& series, size_t index) {
  Markup box;
  if (index < kMostToggles) {
    box = Element("input", {{"type", "checkbox"}, {"checked", "checked"}});
  }
  return Element("label",
                 {{"class", "k" + std::to_string(index)}, {"data-series", std::to_string(index)}},
                 box + Swatch(series.style) + Element("span", {}, series.name));
}

Markup Legend(const std::vector<ChartSeries>& series) {
  Markup legend;
  for (size_t i = 0; i < series.size();) {
    const std::string& group = series[i].group;
    Markup entries;
    for (; i < series.size() && series[i].group == group; ++i) entries += LegendEntry(series[i], i);
    legend += Element("div", {},
                      Element("span", {{"class", "group"}}, group) + Element("div", {}, entries));
  }
  return Element("fieldset", {{"class", "legend"}}, Element("legend", {}, "Show or hide") + legend);
}

}  // namespace

Markup DrawLineChart(const LineChart& chart) {
  Markup caption = Element("strong", {}, chart.title);
  if (!chart.note.empty()) caption += Element("span", {}, chart.note);
  return Element("figure", {{"class", "chart"}, {"id", chart.id}},
                 Element("figcaption", {}, caption) +
                     Element("div", {{"class", "plot"}}, Picture(chart).Draw()) +
                     Legend(chart.series));
}

}  // namespace sweepstake::cli::html
