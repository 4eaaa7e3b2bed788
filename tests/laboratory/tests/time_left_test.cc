#include "tests/laboratory/laboratory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace sweepstake::cli {
namespace {

TEST(DurationText, RoundsToTheUnitThatMatters) {
  EXPECT_EQ(DurationText(40.4), "40 s");
  EXPECT_EQ(DurationText(600), "10 min");
  EXPECT_EQ(DurationText(7300), "2 h 2 min");
  EXPECT_EQ(DurationText(7190), "2 h 0 min");
}

TEST(OnShareWithTimeLeft, AppendsTheTimeThatIsLeft) {
  std::ostringstream out, err;
  Terminal terminal{.out = out, .err = err, .err_is_tty = true, .err_columns = 200};
  {
    Progress progress(terminal, "replay");
    OnShareWithTimeLeft(progress)(0.5, "2 of 4 games");
  }
  EXPECT_THAT(err.str(), testing::HasSubstr("2 of 4 games, 0 s left"));
}

}  // namespace
}  // namespace sweepstake::cli
