#include "server/sessions/lost_sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::sessions {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(LostSessionsTest, TheSessionLostFirstLeavesFirstUnlessItHasUnstoredEvidence) {
  LostSessions sessions;
  EXPECT_THAT(sessions.First(std::nullopt, 9), IsEmpty());
  sessions.Add({1, ""}, {.state = LostState::kUnsettled, .number = 1}, "unsettled");
  sessions.Add({1, ""}, {.state = LostState::kEnding, .number = 0}, "ending");
  sessions.Add({2, ""}, {.state = LostState::kSettled, .number = 3}, "later");
  sessions.Add({1, ""}, {.state = LostState::kSettled, .number = 2}, "first");
  EXPECT_THAT(sessions.First(std::nullopt, 1), ElementsAre("first"));
  EXPECT_THAT(sessions.First(std::nullopt, 3), ElementsAre("first", "later", "unsettled"));
  sessions.Remove({1, ""}, {.state = LostState::kSettled, .number = 2});
  EXPECT_THAT(sessions.First(std::nullopt, 1), ElementsAre("later"));
  sessions.Remove({2, ""}, {.state = LostState::kSettled, .number = 3});
  EXPECT_THAT(sessions.First(std::nullopt, 1), ElementsAre("unsettled"));
  sessions.Remove({1, ""}, {.state = LostState::kUnsettled, .number = 1});
  EXPECT_THAT(sessions.First(std::nullopt, 1), ElementsAre("ending"));
  sessions.Remove({1, ""}, {.state = LostState::kEnding, .number = 0});
  EXPECT_THAT(sessions.First(std::nullopt, 9), IsEmpty());
}

TEST(LostSessionsTest, EachOwnerHasItsOwnOrder) {
  LostSessions sessions;
  sessions.Add({1, ""}, {.state = LostState::kSettled, .number = 1}, "of one");
  sessions.Add({3, ""}, {.state = LostState::kUnsettled, .number = 2}, "of three");
  EXPECT_THAT(sessions.First(LostSessions::Owner(3, ""), 9), ElementsAre("of three"));
  EXPECT_THAT(sessions.First(LostSessions::Owner(1, ""), 9), ElementsAre("of one"));
  EXPECT_THAT(sessions.First(LostSessions::Owner(2, ""), 9), IsEmpty());
  EXPECT_THAT(sessions.First(LostSessions::Owner(4, ""), 9), IsEmpty());
  sessions.Remove({3, ""}, {.state = LostState::kUnsettled, .number = 2});
  EXPECT_THAT(sessions.First(LostSessions::Owner(3, ""), 9), IsEmpty());
}

}  // namespace
}  // namespace sweepstake::sessions
