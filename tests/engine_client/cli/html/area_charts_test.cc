// Timelines, stacked bars, small multiples and the linear axis they share.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/html/linear_axis.h"
#include "engine_client/cli/html/small_multiples.h"
#include "engine_client/cli/html/stacked_bars.h"
#include "engine_client/cli/html/timeline_chart.h"
#include "tests/engine_client/cli/html/well_formed.h"

namespace sweepstake::cli::html {
namespace {

using test_support::FirstFlaw;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(LinearAxis, TicksAreRoundAndWithinIt) {
  const LinearAxis axis(0, 15.7);
  EXPECT_THAT(axis.Ticks(10), ElementsAre(0, 2, 4, 6, 8, 10, 12, 14));
  EXPECT_EQ(axis.Text(4, 10), "4");
  const LinearAxis narrow(0.512, 0.568);
  EXPECT_THAT(narrow.Ticks(4), ElementsAre(DoubleEq(0.52), DoubleEq(0.54), DoubleEq(0.56)));
  EXPECT_EQ(narrow.Text(0.54, 4), "0.54");
  EXPECT_THAT(LinearAxis(-1, 1).Ticks(3), ElementsAre(-1, 0, 1));
}

TEST(LinearAxis, OfOneValueHasItInTheMiddle) {
  EXPECT_DOUBLE_EQ(LinearAxis(3, 3).Position(3), 0.5);
  EXPECT_DOUBLE_EQ(LinearAxis(0, 0).Position(0), 0.5);
}

TEST(Area, HasItsNameOnlyWhereThereIsRoom) {
  EXPECT_THAT(DrawArea({.width = 60, .height = 20, .text = "KDTree", .title = "t"}).html(),
              HasSubstr(">KDTree</text>"));
  EXPECT_THAT(DrawArea({.width = 20, .height = 20, .text = "KDTree", .title = "t"}).html(),
              Not(HasSubstr("<text")));
  EXPECT_THAT(DrawArea({.width = 0, .height = 20, .text = "", .title = "t"}).html(),
              HasSubstr("width=\"0.5\""));
}

TEST(StackedBars, DivideTheWholeAndNameWhatIsWide) {
  const StackedBars chart{"id", "<Title>", "note", {"a", "b", "c"}, {{"row", "group", {3, 1, 0}}}};
  const std::string html = DrawStackedBars(chart).html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr(">a 75.0 %</text>"));
  EXPECT_THAT(html, HasSubstr("<title>row: b 25.0 %</title>"));
  EXPECT_THAT(html, Not(HasSubstr("row: c")));
  EXPECT_THAT(html, HasSubstr("&lt;Title&gt;"));
  EXPECT_EQ(Count(html, "class=\"chip "), 3U) << "all kinds are in the legend";
}

TEST(StackedBars, StandWithoutAnything) {
  EXPECT_EQ(FirstFlaw(DrawStackedBars({"id", "t", "", {"a"}, {{"row", "", {0}}}}).html()), "");
  EXPECT_EQ(FirstFlaw(DrawStackedBars({"id", "t", "", {}, {}}).html()), "");
}

TimelineChart OneLane() {
  TimelineLane lane{"lane <1>",
                    {{0, 4, 0, "early", true}, {4, 10, 1, "late & long", false}},
                    {5, 5.001, 7},
                    {{6, "crash"}}};
  return {"id", "Title", "", "minutes", 10, {"A", "B"}, {lane}};
}

TEST(Timeline, DrawsStretchesStrokesAndMarks) {
  const std::string html = DrawTimelineChart(OneLane()).html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("<title>lane &lt;1&gt;: late &amp; long</title>"));
  EXPECT_EQ(Count(html, "class=\"area a0 before\""), 1U);
  EXPECT_EQ(Count(html, "class=\"area a1\""), 1U);
  EXPECT_THAT(html, HasSubstr("lane &lt;1&gt;: crash"));
  const std::string strokes = html.substr(html.find("class=\"strokes\""));
  EXPECT_EQ(Count(strokes.substr(0, strokes.find("/>")), "M"), 2U) << "what coincides is one";
  EXPECT_THAT(html, HasSubstr("<desc "));
}

TEST(Timeline, StandsWithoutLanes) {
  TimelineChart chart = OneLane();
  chart.lanes.clear();
  EXPECT_EQ(FirstFlaw(DrawTimelineChart(chart).html()), "");
}

TEST(SmallMultiples, ShareTheirAxesAndNameTheStrongLine) {
  const SmallMultiples chart{"id",
                             "Title",
                             "",
                             "minutes",
                             "mean",
                             {"A", "B"},
                             {{"first", "n", {{0, false, {{0, 0}, {1, 1}}}}},
                              {"second", "", {{1, true, {{0, 0}, {kNan, 3}, {0.5, 0.5}}}}}}};
  const std::string html = DrawSmallMultiples(chart).html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_EQ(Count(html, "<svg"), 2U);
  EXPECT_THAT(html, HasSubstr(">B</text>"));
  EXPECT_THAT(html, Not(HasSubstr(">A</text>"))) << "its line is thin";
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_EQ(
      FirstFlaw(DrawSmallMultiples({"id", "t", "", "x", "y", {}, {{"empty", "", {}}}}).html()), "");
}

}  // namespace
}  // namespace sweepstake::cli::html
