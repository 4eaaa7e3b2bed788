// The pages of the command line in general: escaping, numbers, axes, charts, tables, the shell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine_client/cli/html/line_chart.h"
#include "engine_client/cli/html/log_axis.h"
#include "engine_client/cli/html/markup.h"
#include "engine_client/cli/html/page.h"
#include "engine_client/cli/html/range_chart.h"
#include "engine_client/cli/html/table.h"
#include "engine_client/cli/io/numbers.h"
#include "tests/engine_client/cli/html/well_formed.h"

namespace sweepstake::cli::html {
namespace {

using test_support::FirstFlaw;
using testing::HasSubstr;
using testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(WellFormed, SeesWhatIsWrong) {
  EXPECT_EQ(FirstFlaw("<p class=\"a\">x &amp; y<br/></p>"), "");
  for (const char* broken : {"<p>", "</p>", "<p><b></p></b>", "<p>a & b</p>", "<p a=b></p>",
                             "<p id=\"x\"></p><p id=\"x\"></p>", "<p>a > b</p>", "<p>a < b</p>"}) {
    EXPECT_NE(FirstFlaw(broken), "") << broken;
  }
}

TEST(Escape, LeavesNoMarkupInText) {
  EXPECT_EQ(Escape("<script>\"a\" & 'b'</script>"),
            "&lt;script&gt;&quot;a&quot; &amp; &#39;b&#39;&lt;/script&gt;");
  EXPECT_EQ(Escape("größer · 大 · 😀"), "größer · 大 · 😀");
  EXPECT_EQ(Escape("a\tb\nc"), "a\tb\nc");
}

TEST(Escape, ReplacesWhatIsNoUtf8AndControlCharacters) {
  EXPECT_EQ(Escape("a\xff\x62"), "a\uFFFD\x62");
  EXPECT_EQ(Escape("\xc3"), "\uFFFD");
  EXPECT_EQ(Escape("\xe2\x82"), "\uFFFD\uFFFD");
  EXPECT_EQ(Escape("\xc0\xaf"), "\uFFFD\uFFFD");            // overlong
  EXPECT_EQ(Escape("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(Escape("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(Escape(std::string_view("a\0b\x1b\x7f", 5)), "a\uFFFD\x62\uFFFD\uFFFD");
}

TEST(Element, EscapesTextAndAttributesButNotMarkup) {
  EXPECT_EQ(Element("p", {{"title", "\"<&"}}, Element("b", {}, "<i>")).html(),
            "<p title=\"&quot;&lt;&amp;\"><b>&lt;i&gt;</b></p>");
}

TEST(EmbeddedJson, CannotEndItsScript) {
  const std::string embedded = EmbeddedJson(R"({"scene":"</script><!--"})").html();
  EXPECT_THAT(embedded, Not(HasSubstr("<")));
  EXPECT_EQ(embedded, R"({"scene":"\u003c/script>\u003c!--"})");
}

TEST(Significant, ShowsThatManyDigitsWithoutAnExponent) {
  EXPECT_EQ(Significant(0.034567, 3), "0.0346");
  EXPECT_EQ(Significant(12.345, 3), "12.3");
  EXPECT_EQ(Significant(9.996, 3), "10.0");
  EXPECT_EQ(Significant(99.96, 3), "100");
  EXPECT_EQ(Significant(1234, 3), "1230");
  EXPECT_EQ(Significant(-0.5, 2), "-0.50");
  EXPECT_EQ(Significant(0, 3), "0");
  EXPECT_EQ(Significant(0.00001, 1), "0.00001");
  EXPECT_EQ(Significant(kNan, 3), "–");
  EXPECT_EQ(Significant(kInfinity, 3), "–");
}

TEST(Grouped, SeparatesThousands) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1000), "1,000");
  EXPECT_EQ(Grouped(12345678), "12,345,678");
  EXPECT_EQ(GroupedWhole(1233.5), "1,234");
}

TEST(Compact, AndBytesUseLargerUnits) {
  EXPECT_EQ(Compact(800), "800");
  EXPECT_EQ(Compact(1000), "1k");
  EXPECT_EQ(Compact(2500), "2.5k");
  EXPECT_EQ(Compact(999'999), "1M");
  EXPECT_EQ(Compact(1e6), "1M");
  EXPECT_EQ(Compact(1.7), "1.7");
  EXPECT_EQ(Compact(kNan), "–");
  EXPECT_EQ(Bytes(512), "512 B");
  EXPECT_EQ(Bytes(11'240), "11.2 kB");
  EXPECT_EQ(Bytes(3'400'000), "3.40 MB");
}

std::vector<double> Labels(const LogAxis& axis) {
  std::vector<double> labels;
  for (const Tick& tick : axis.Ticks()) {
    if (tick.labelled) labels.push_back(tick.value);
  }
  return labels;
}

TEST(LogAxis, LabelsOneTwoFiveOverAFewDecadesAndDecadesOverMany) {
  const std::array<double, 2> few{1, 100};
  EXPECT_THAT(Labels(LogAxis(few, 1)), testing::ElementsAre(1, 2, 5, 10, 20, 50, 100));
  const std::array<double, 2> many{0.01, 1000};
  const auto labels = Labels(LogAxis(many, 1));
  ASSERT_EQ(labels.size(), 6U);
  EXPECT_NEAR(labels.front(), 0.01, 1e-12);
  EXPECT_NEAR(labels.back(), 1000, 1e-9);
}

TEST(LogAxis, HoldsEveryValueAndItsTicksAscend) {
  for (const double low : {1e-9, 0.00037, 1.0, 9.99, 123456.0}) {
    for (const double factor : {1.0, 1.001, 3.0, 42.0, 1e6, 1e17}) {
      const std::array<double, 2> values{low, low * factor};
      const LogAxis axis(values, 1.5);
      EXPECT_LE(axis.low(), low);
      EXPECT_GE(axis.high(), low * factor);
      const auto ticks = axis.Ticks();
      EXPECT_TRUE(std::is_sorted(ticks.begin(), ticks.end(),
                                 [](const Tick& a, const Tick& b) { return a.value < b.value; }));
      EXPECT_GE(Labels(axis).size(), 2U) << low << " " << factor;
      EXPECT_LE(Labels(axis).size(), 16U) << low << " " << factor;
      for (const Tick& tick : ticks) {
        EXPECT_GE(axis.Position(tick.value), 0);
        EXPECT_LE(axis.Position(tick.value), 1);
      }
    }
  }
}

TEST(LogAxis, PassesOverWhatHasNoLogarithm) {
  const std::array<double, 6> values{0, -1, kNan, kInfinity, 2, 20};
  const LogAxis axis(values, 1);
  EXPECT_EQ(axis.low(), 2);
  EXPECT_EQ(axis.high(), 20);
  const std::array<double, 1> none{0};
  EXPECT_EQ(LogAxis(none, 2).low(), 1);
  EXPECT_EQ(LogAxis({}, 2).high(), 10);
}

TEST(LogAxis, KeepsTheLabelsOfValuesApart) {
  const std::array<double, 5> values{1000, 1010, 3000, 9900, 10000};
  const LogAxis axis(values, 1.25);
  EXPECT_THAT(SpacedOut(axis, values, 0.07), testing::ElementsAre(1000, 3000, 10000));
}

LineChart TwoLines() {
  return {"chart",
          "A & B",
          "note",
          "Objects",
          "ms",
          {{"ours", "Family", {0, true}, {{1000, 0.5, "half"}, {10000, 5, "five"}}},
           {"<peer>", "Family", {0, false}, {{1000, 0, "none"}, {10000, kNan, "none"}}}}};
}

TEST(LineChart, DrawsEveryPointThatHasAPlaceAndNamesEveryLine) {
  const std::string html = DrawLineChart(TwoLines()).html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("ours: half"));
  EXPECT_THAT(html, HasSubstr("ours: five"));
  EXPECT_THAT(html, Not(HasSubstr("none")));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, HasSubstr("&lt;peer&gt;"));
  EXPECT_THAT(html, HasSubstr("series k0 c0 solid"));
  EXPECT_THAT(html, HasSubstr("series k1 c0 dashed"));
}

TEST(LineChart, StandsWithNothingToDraw) {
  LineChart chart = TwoLines();
  chart.series.clear();
  EXPECT_EQ(FirstFlaw(DrawLineChart(chart).html()), "");
}

TEST(LineChart, KeepsTheNamesOfManyLinesApart) {
  LineChart chart = TwoLines();
  chart.series.clear();
  for (size_t i = 0; i < 60; ++i) {
    chart.series.push_back({"s" + std::to_string(i), "all", {i, true}, {{10, 1, "same"}}});
  }
  const std::string html = DrawLineChart(chart).html();
  std::vector<double> heights;
  for (size_t at = html.find("end-name"); at != std::string::npos;
       at = html.find("end-name", at + 1)) {
    const size_t y = html.rfind(" y=\"", at) + 4;
    heights.push_back(std::stod(html.substr(y)));
  }
  ASSERT_EQ(heights.size(), 60U);
  std::sort(heights.begin(), heights.end());
  for (size_t i = 1; i < heights.size(); ++i) EXPECT_GE(heights[i] - heights[i - 1], 14.8);
}

TEST(RangeChart, HasARowForEachThatHasAPlace) {
  const std::string html = DrawRangeChart({"r",
                                           "Title",
                                           "",
                                           "ms",
                                           {{"a<", {1, true}, 1, 2, 4, "2 ms", "said"},
                                            {"b", {2, false}, 0, 0, 0, "0 ms", "unsaid"}}})
                               .html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("a&lt;"));
  EXPECT_THAT(html, HasSubstr("2 ms"));
  EXPECT_THAT(html, Not(HasSubstr("unsaid")));
}

TEST(Table, NamesRowsColumnsAndGroups) {
  const std::string html = DrawTable({"t",
                                      "Caption <1>",
                                      {{{Markup()}, {"Both", "", 2}}, {{"Name"}, {"A"}, {"B"}}},
                                      {{"Group", {{{"row"}, {"1", "met"}, {"2"}}}}}})
                               .html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("Caption &lt;1&gt;"));
  EXPECT_THAT(html, HasSubstr("<th colspan=\"2\" scope=\"colgroup\">Both</th>"));
  EXPECT_THAT(html, HasSubstr("scope=\"rowgroup\" colspan=\"3\""));
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\">row</th><td class=\"met\">1</td>"));
}

TEST(Page, IsOneFileWithBothThemesThatLoadsNothing) {
  const std::string html = WritePage({"T", "lead", {{"one", "First", DrawLineChart(TwoLines())}}});
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("default-src &#39;none&#39;"));
  EXPECT_THAT(html, HasSubstr("prefers-color-scheme: dark"));
  EXPECT_THAT(html, HasSubstr(":root:has(#theme-dark:checked)"));
  EXPECT_THAT(html, HasSubstr(":root:has(#theme-light:checked)"));
  EXPECT_THAT(html, HasSubstr("id=\"theme-dark\""));
  EXPECT_THAT(html, HasSubstr("href=\"#one\""));
  EXPECT_THAT(html, HasSubstr(".k1>input:not(:checked)"));
  for (const char* loading : {"://", "src=", "@import", "url(", "<link", "fetch("}) {
    EXPECT_THAT(html, Not(HasSubstr(loading)));
  }
}

TEST(Page, HidesWhatNeedsTheScriptUntilItRuns) {
  const std::string html = EmbedRows("rows", "{}").html();
  EXPECT_EQ(FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("hidden=\"hidden\""));
  EXPECT_THAT(html, HasSubstr("<script type=\"application/json\" id=\"rows\">{}</script>"));
}

}  // namespace
}  // namespace sweepstake::cli::html
