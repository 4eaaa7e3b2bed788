// Tests the cookies of logins, and how long they are valid.
#include "server/web/api/logins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sweepstake::web {
namespace {

using ::testing::MatchesRegex;
using ::testing::Optional;

TEST(LoginsTest, ACookieIsRandomAndFindsItsToken) {
  Logins logins;
  const std::string first = logins.Begin("ann", 0);
  const std::string second = logins.Begin("ann", 0);
  EXPECT_THAT(first, MatchesRegex("[0-9a-f]{64}"));
  EXPECT_NE(first, second);
  EXPECT_THAT(logins.Find(first, 1), Optional(std::string("ann")));
  EXPECT_EQ(logins.Find("", 1), std::nullopt);
  EXPECT_EQ(logins.Find("ann", 1), std::nullopt);
  logins.End(first);
  EXPECT_EQ(logins.Find(first, 1), std::nullopt);
  EXPECT_THAT(logins.Find(second, 1), Optional(std::string("ann")));
}

TEST(LoginsTest, ALoginThatIsNotUsedEnds) {
  Logins logins;
  const std::string cookie = logins.Begin("ann", 0);
  EXPECT_TRUE(logins.Find(cookie, Logins::kPatienceS));
  EXPECT_TRUE(logins.Find(cookie, 2 * Logins::kPatienceS)) << "it was used";
  EXPECT_FALSE(logins.Find(cookie, 3 * Logins::kPatienceS + 1));
  EXPECT_EQ(logins.size(), 0u);
  logins.Begin("ann", 0);
  logins.Begin("bob", Logins::kPatienceS + 1);
  EXPECT_EQ(logins.size(), 1u) << "logins that are not used end, too";
}

TEST(LoginsTest, TheLoginsOfATokenAreBoundedAndLeaveOthersAlone) {
  Logins logins;
  const std::string others = logins.Begin("bob", 0);
  const std::string oldest = logins.Begin("ann", 1);
  const std::string used = logins.Begin("ann", 2);
  for (size_t i = 2; i < Logins::kMaxOfToken; ++i) logins.Begin("ann", 3);
  EXPECT_TRUE(logins.Find(oldest, 4) && logins.Find(used, 5));
  EXPECT_TRUE(logins.Find(oldest, 6));
  for (size_t i = 2; i < Logins::kMaxOfToken; ++i) logins.Begin("ann", 7);
  logins.Begin("ann", 7);
  EXPECT_FALSE(logins.Find(used, 8));
  EXPECT_TRUE(logins.Find(oldest, 8));
  EXPECT_TRUE(logins.Find(others, 8));
}

TEST(LoginsTest, AllLoginsAreBounded) {
  Logins logins;
  const std::string oldest = logins.Begin("0", 0);
  for (size_t i = 1; i < Logins::kMaxLogins; ++i) logins.Begin(std::to_string(i), 1);
  EXPECT_EQ(logins.size(), Logins::kMaxLogins);
  logins.Begin("one more", 1);
  EXPECT_EQ(logins.size(), Logins::kMaxLogins);
  EXPECT_FALSE(logins.Find(oldest, 1));
}

}  // namespace
}  // namespace sweepstake::web
