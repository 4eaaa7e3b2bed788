#include "engine_client/cli/io/duration.h"

#include <gtest/gtest.h>

namespace sweepstake::cli {
namespace {

TEST(ParseDuration, AcceptsANumberAndAUnit) {
  EXPECT_EQ(*ParseDuration("500ms"), 500'000'000U);
  EXPECT_EQ(*ParseDuration("60s"), 60'000'000'000U);
  EXPECT_EQ(*ParseDuration("15m"), 900'000'000'000U);
  EXPECT_EQ(*ParseDuration("1.5h"), 5'400'000'000'000U);
}

TEST(ParseDuration, RejectsEverythingElseAndStatesTheFormat) {
  for (const char* text :
       {"", "60", "s", "-1s", "0s", "1e9s", "nans", "inf", "1 s", "1d", "1s1", "1000h", "١s"}) {
    const auto duration = ParseDuration(text);
    ASSERT_FALSE(duration.ok()) << text;
    EXPECT_NE(duration.status().message().find("15m"), std::string::npos) << text;
  }
}

TEST(ParseDuration, AcceptsUpToThirtyDays) {
  EXPECT_EQ(*ParseDuration("720h"), 2'592'000'000'000'000U);
  EXPECT_FALSE(ParseDuration("720.1h").ok());
  EXPECT_FALSE(ParseDuration("0s").ok());
  EXPECT_EQ(*ParseDuration("0s", /*min_ns=*/0), 0u);
  EXPECT_FALSE(ParseDuration("-1s", /*min_ns=*/0).ok());
  EXPECT_FALSE(ParseDuration("0.0000001ms").ok());
}

TEST(ParseDuration, RepeatsTheInputInTheError) {
  EXPECT_NE(ParseDuration("soon").status().message().find("'soon' is not a duration"),
            std::string::npos);
}

}  // namespace
}  // namespace sweepstake::cli
