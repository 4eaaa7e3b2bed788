#include "server/sessions/lost_sessions.h"

#include <gtest/gtest.h>

namespace sweepstake::sessions {
namespace {

TEST(LostSessionsTest, TheSessionLostFirstLeavesFirstUnlessItHasUnstoredEvidence) {
  LostSessions sessions;
  EXPECT_FALSE(sessions.First(std::nullopt));
  sessions.Add({1, ""}, {.state = LostState::kUnsettled, .number = 1}, "unsettled");
  sessions.Add({1, ""}, {.state = LostState::kEnding, .number = 0}, "ending");
  sessions.Add({2, ""}, {.state = LostState::kSettled, .number = 3}, "later");
  sessions.Add({1, ""}, {.state = LostState::kSettled, .number = 2}, "first");
  EXPECT_EQ(sessions.First(std::nullopt), "first");
  sessions.Remove({1, ""}, {.state = LostState::kSettled, .number = 2});
  EXPECT_EQ(sessions.First(std::nullopt), "later");
  sessions.Remove({2, ""}, {.state = LostState::kSettled, .number = 3});
  EXPECT_EQ(sessions.First(std::nullopt), "unsettled");
  sessions.Remove({1, ""}, {.state = LostState::kUnsettled, .number = 1});
  EXPECT_EQ(sessions.First(std::nullopt), "ending");
  sessions.Remove({1, ""}, {.state = LostState::kEnding, .number = 0});
  EXPECT_FALSE(sessions.First(std::nullopt));
}

TEST(LostSessionsTest, EachOwnerHasItsOwnOrder) {
  LostSessions sessions;
  sessions.Add({1, ""}, {.state = LostState::kSettled, .number = 1}, "of one");
  sessions.Add({3, ""}, {.state = LostState::kUnsettled, .number = 2}, "of three");
  EXPECT_EQ(sessions.First(LostSessions::Owner(3, "")), "of three");
  EXPECT_EQ(sessions.First(LostSessions::Owner(1, "")), "of one");
  EXPECT_FALSE(sessions.First(LostSessions::Owner(2, "")));
  EXPECT_FALSE(sessions.First(LostSessions::Owner(4, "")));
  sessions.Remove({3, ""}, {.state = LostState::kUnsettled, .number = 2});
  EXPECT_FALSE(sessions.First(LostSessions::Owner(3, "")));
}

}  // namespace
}  // namespace sweepstake::sessions
