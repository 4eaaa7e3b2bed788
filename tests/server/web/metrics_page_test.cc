// Tests the text of /metrics.
#include "server/web/metrics_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::web {
namespace {

using ::testing::HasSubstr;

TEST(MetricsPageTest, AFamilyHasItsHelpTypeAndValue) {
  const Page page =
      MetricsPage({CounterOf("games_total", "Games.", 3), GaugeOf("open", "Open.", 1)});
  EXPECT_THAT(page.content_type, HasSubstr("version=0.0.4"));
  EXPECT_EQ(page.body,
            "# HELP games_total Games.\n# TYPE games_total counter\ngames_total 3\n"
            "# HELP open Open.\n# TYPE open gauge\nopen 1\n");
}

}  // namespace
}  // namespace sweepstake::web
