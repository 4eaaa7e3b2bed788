#include "engine_client/cli/html/area_marks.h"

#include <algorithm>

#include "engine_client/cli/html/chart_marks.h"
#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli::html {
namespace {

constexpr double kLetterWidth = 6.6;  // of the page's font at 11 units, on average, generously
constexpr double kLeastHeight = 11;

}  // namespace

std::string AreaClass(size_t kind) { return "a" + std::to_string(kind % kAreaCount); }

Markup DrawArea(const Area& area) {
  const double width = std::max(area.width, 0.5);
  Markup content =
      Element("title", {}, area.title) + Element("rect", {{"x", Pixels(area.x)},
                                                          {"y", Pixels(area.y)},
                                                          {"width", Pixels(width)},
                                                          {"height", Pixels(area.height)}});
  const double needed = kLetterWidth * static_cast<double>(LetterCount(area.text)) + 6;
  if (!area.text.empty() && needed <= width && area.height >= kLeastHeight) {
    content +=
        SvgText(area.x + width / 2, area.y + area.height / 2 + 4, "middle", "on-area", area.text);
  }
  return Element("g", {{"class", "area " + AreaClass(area.kind) + (area.faint ? " before" : "")}},
                 content);
}

Markup AreaChip(size_t kind, const std::string& name) {
  return Element("span", {{"class", "chip " + AreaClass(kind)}}, name);
}

Markup AreaLegend(const std::vector<std::string>& kinds) {
  Markup chips;
  for (size_t kind = 0; kind < kinds.size(); ++kind) chips += AreaChip(kind, kinds[kind]);
  return Element("p", {{"class", "chips"}}, chips);
}

Markup DrawFigure(const AreaFigure& figure, const Markup& picture, const Markup& below) {
  Markup caption = Element("strong", {}, figure.title);
  if (!figure.note.empty()) caption += Element("span", {}, figure.note);
  const std::string title_id = figure.id + "-title", summary_id = figure.id + "-summary";
  const Markup svg =
      Element("svg",
              {{"viewBox", "0 0 " + Pixels(figure.width) + " " + Pixels(figure.height)},
               {"role", "img"},
               {"aria-labelledby", title_id + " " + summary_id}},
              Element("title", {{"id", title_id}}, figure.title) +
                  Element("desc", {{"id", summary_id}}, figure.summary) + picture);
  return Element(
      "figure", {{"class", "chart areas"}, {"id", figure.id}},
      Element("figcaption", {}, caption) + Element("div", {{"class", "plot"}}, svg) + below);
}

}  // namespace sweepstake::cli::html
