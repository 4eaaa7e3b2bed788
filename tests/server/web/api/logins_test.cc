// Which cookie stands for which token, for how long, and what is kept of that.
#include "server/web/api/logins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "server/web/api/token_seal.h"

namespace sweepstake::web {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::Optional;

TEST(LoginsTest, ACookieIsRandomAndStandsForItsToken) {
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
  EXPECT_EQ(logins.size(), 1u) << "those that nobody asks for end, too";
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

TEST(LoginsTest, WhatIsKeptGoesOnAndTellsNeitherTheCookieNorTheToken) {
  Logins before;
  const std::string ann = before.Begin("ann-token", 1);
  const std::string bob = before.Begin("bob-token", 2);
  before.Find(ann, 3);
  const std::vector<Login> kept = before.All();
  for (const Login& login : kept) {
    for (const std::string& text : {login.cookie_digest, login.token_digest, login.sealed_token}) {
      for (const std::string& secret : {ann, bob, std::string("-token")})
        EXPECT_THAT(text, Not(HasSubstr(secret)));
    }
  }
  Logins after(kept);
  EXPECT_THAT(after.Find(ann, 4), Optional(std::string("ann-token")));
  EXPECT_EQ(after.Find(bob, 3 + Logins::kPatienceS), std::nullopt) << "used last at 2";
  EXPECT_EQ(after.size(), 1u);
  EXPECT_EQ(after.Begin("ann-token", 5).size(), 64u);
  std::vector<Login> mixed = kept;
  std::swap(mixed[0].sealed_token, mixed[1].sealed_token);
  EXPECT_EQ(Logins(mixed).Find(ann, 4), std::nullopt) << "another login's token";
}

TEST(LoginsTest, SaysWhenThereIsSomethingToKeep) {
  Logins logins;
  EXPECT_FALSE(logins.TakeChanged(1'000'000)) << "nothing was ever there";
  const std::string cookie = logins.Begin("ann", 1'000'000);
  EXPECT_TRUE(logins.TakeChanged(1'000'000));
  logins.Find(cookie, 1'000'001);
  EXPECT_FALSE(logins.TakeChanged(1'000'001)) << "a use";
  EXPECT_TRUE(logins.TakeChanged(1'000'000 + Logins::kTellUsesS)) << "uses of a day";
  EXPECT_FALSE(logins.TakeChanged(1'000'000 + Logins::kTellUsesS));
  logins.End(cookie);
  EXPECT_TRUE(logins.TakeChanged(1'000'000 + Logins::kTellUsesS));
}

TEST(TokenSealTest, OpensWithItsCookieAlone) {
  const std::string sealed = SealToken("cookie", "token");
  EXPECT_EQ(sealed.size(), 5u + 16u);
  EXPECT_THAT(OpenToken("cookie", sealed), Optional(std::string("token")));
  EXPECT_EQ(OpenToken("Cookie", sealed), std::nullopt);
  EXPECT_EQ(OpenToken("cookie", ""), std::nullopt);
  EXPECT_EQ(OpenToken("cookie", sealed.substr(1)), std::nullopt);
  for (size_t i = 0; i < sealed.size(); ++i) {
    std::string changed = sealed;
    changed[i] ^= 1;
    EXPECT_EQ(OpenToken("cookie", changed), std::nullopt) << i;
  }
}

}  // namespace
}  // namespace sweepstake::web
