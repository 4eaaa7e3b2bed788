// Tests logins: cookies, roles, and the places that store a token.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/web/api/api_fixture.h"
#include "tests/server/web/fake_exchange.h"

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

constexpr char kList[] = "PosteriorsService/ListPosteriors";

TEST_F(ApiTest, WithoutTokensEverybodyIsAdminAndNobodyLogsIn) {
  EXPECT_EQ(Get("/api/whoami").body,
            R"({"version":"0.1.0","asksForTokens":false,"loggedIn":false,"name":"",)"
            R"("role":"admin","stableProbability":0.8,"tieLossRatio":0.005,"projects":[]})");
  EXPECT_EQ(Post("/login", R"({"token":"x"})").status, 400);
}

TEST_F(ApiTokensTest, ALoginReturnsACookieForTheToken) {
  const Answer login = Post("/login", R"({"token":"mine-token"})");
  EXPECT_EQ(login.status, 204);
  EXPECT_THAT(login.head, Not(HasSubstr("mine-token")));
  const size_t start = login.head.find("Set-Cookie: ");
  EXPECT_THAT(
      login.head.substr(start, login.head.find('\r', start) - start),
      MatchesRegex("Set-Cookie: sweepstake=[0-9a-f]{64}; HttpOnly; SameSite=Strict; Path=/"));
  const std::string cookie = LogIn("mine-token");
  EXPECT_EQ(Call(kList, "{}", cookie).status, 200);
  EXPECT_EQ(Call(kList, R"({"project":"theirs"})", cookie).status, 403);
  EXPECT_EQ(
      Get("/api/whoami", cookie).body,
      R"({"version":"0.1.0","asksForTokens":true,"loggedIn":true,"name":"mine",)"
      R"("role":"operator","stableProbability":0.8,"tieLossRatio":0.005,"projects":["game","mine"]})");
  EXPECT_EQ(Get("/api/whoami", Bearer("ann-token")).body,
            R"({"version":"0.1.0","asksForTokens":true,"loggedIn":true,"name":"ann",)"
            R"("role":"watch","stableProbability":0.8,"tieLossRatio":0.005,"projects":[]})");
}

// Browsers send cookies to all ports of a host.
TEST_F(ApiTokensTest, DaemonsOnOneHostHaveDifferentCookies) {
  host_ = "localhost:7434";
  const std::string cookie = LogIn("ann-token");
  EXPECT_THAT(cookie, HasSubstr("; sweepstake-7434="));
  EXPECT_EQ(Call(kList, "{}", cookie).status, 200);
  EXPECT_THAT(Post("/logout", "", "").head, HasSubstr("Set-Cookie: sweepstake-7434=; "));
  host_ = "localhost:7435";
  EXPECT_EQ(Call(kList, "{}", cookie).status, 401) << "the other daemon's";
  for (const char* without : {"127.0.0.1", "[::1]"}) {
    host_ = without;
    EXPECT_THAT(LogIn("ann-token"), HasSubstr("; sweepstake=")) << without;
  }
}

TEST_F(ApiTokensTest, TheCookieIsOnlySentBelowTheBasePath) {
  limits_.base_path = "/tools";
  StartHttp();
  const Answer login = Post("/tools/login", R"({"token":"ann-token"})");
  EXPECT_THAT(login.head, HasSubstr("; Path=/tools/\r\n"));
}

TEST_F(ApiTokensTest, OverTlsTheCookieIsSecure) {
  const Answer login = Post("/login", R"({"token":"ann-token"})", "X-Forwarded-Proto: https\r\n");
  EXPECT_THAT(login.head, HasSubstr("; Path=/; Secure\r\n"));
}

TEST_F(ApiTokensTest, ALogoutEndsTheLogin) {
  const std::string cookie = LogIn("ann-token");
  const std::string other = LogIn("ann-token");
  const Answer logout = Post("/logout", "", cookie);
  EXPECT_EQ(logout.status, 204);
  EXPECT_THAT(logout.head, HasSubstr("Set-Cookie: sweepstake=; "));
  EXPECT_THAT(logout.head, HasSubstr("Max-Age=0"));
  EXPECT_EQ(Call(kList, "{}", cookie).status, 401);
  EXPECT_EQ(Call(kList, "{}", other).status, 200);
}

TEST_F(ApiTokensTest, ANewLoginEndsThatOfTheSameBrowser) {
  const std::string cookie = LogIn("ann-token");
  EXPECT_EQ(Post("/login", R"({"token":"mine-token"})", cookie).status, 204);
  EXPECT_EQ(Call(kList, "{}", cookie).status, 401);
}

TEST_F(ApiTokensTest, TheLoginOfARevokedTokenEnds) {
  const std::string cookie = LogIn("ann-token");
  tokens_.Revoke("ann");
  EXPECT_EQ(Call(kList, "{}", cookie).status, 401);
  EXPECT_EQ(Get("/api/whoami", cookie).body,
            R"({"version":"0.1.0","asksForTokens":true,"loggedIn":false,"name":"",)"
            R"("role":"","stableProbability":0.8,"tieLossRatio":0.005,"projects":[]})");
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(Get("/api/whoami", cookie).status, 200) << "the login has ended, and guesses nothing";
}

TEST_F(ApiTokensTest, AFailedLoginDoesNotEndALogin) {
  const std::string cookie = LogIn("ann-token");
  EXPECT_EQ(Get("/api/whoami", cookie + Bearer("guess")).status, 200);
  EXPECT_EQ(Call(kList, "{}", cookie).status, 200);
}

TEST_F(ApiTokensTest, AnInvalidLoginIsRefused) {
  for (const std::string& body : {std::string(""), std::string("{"), std::string("[]"),
                                  std::string("\"ann-token\""), std::string(R"({"token":7})"),
                                  std::string(R"({"token":""})"), std::string(R"({"token":"a b"})"),
                                  std::string(100'000, '['), std::string(R"({"token":"a\nb"})")}) {
    EXPECT_EQ(Post("/login", body).status, 400) << body.substr(0, 50);
  }
  EXPECT_THAT(Get("/logout").head, HasSubstr("Allow: POST\r\n"));
}

TEST_F(ApiTokensTest, ATokenThatCannotReadIsNotLoggedIn) {
  const Answer login = Post("/login", R"({"token":"game-token"})");
  EXPECT_EQ(login.status, 403);
  EXPECT_THAT(login.body, HasSubstr("a token of the role ingest cannot read"));
  EXPECT_THAT(login.head, Not(HasSubstr("Set-Cookie")));
}

TEST_F(ApiTokensTest, AfterManyFailuresGuessesAreRefusedAndAValidTokenIsNot) {
  for (uint32_t i = 0; i < auth::FailureLimit::kMaxFailures; ++i) {
    const Answer wrong =
        i % 2 == 0 ? Post("/login", R"({"token":"guess"})") : Get("/api/whoami", Bearer("guess"));
    EXPECT_EQ(wrong.status, i % 2 == 0 ? 401 : 200) << i;
  }
  EXPECT_EQ(Post("/login", R"({"token":"guess"})").status, 429);
  EXPECT_EQ(Get("/api/whoami", Bearer("guess")).status, 429);
  EXPECT_EQ(Call(kList, "{}", Bearer("guess")).status, 429);
  EXPECT_EQ(Get("/api/whoami").status, 200) << "a request without a cookie is not a failed login";
  EXPECT_EQ(Call(kList, "{}", LogIn("ann-token")).status, 200);
  EXPECT_THAT(logged_->text(), HasSubstr("ipv4:127.0.0.1"));
}

TEST_F(ApiTokensTest, ATokenIsNeverSentBack) {
  tokens_.Add("canary", auth::Role::kWatch);
  const std::string cookie = LogIn("canary-token");
  std::string told =
      Call(kList, "{}", cookie).body + Call(kList, "{}", Bearer("canary-token")).body +
      Get("/api/whoami", cookie).body + Call("SessionsService/KickSession", "{}", cookie).body;
  tokens_.Revoke("canary");
  told += Call(kList, "{}", cookie).body + Post("/login", R"({"token":"canary-token"})").body +
          Post("/login", R"({"token":"canary-token)").body + Get("/api/whoami", cookie).body;
  const size_t start = cookie.rfind('=') + 1;
  for (const std::string& secret : {std::string("canary-token"), cookie.substr(start, 64)}) {
    EXPECT_THAT(told, Not(HasSubstr(secret)));
    EXPECT_THAT(logged_->text(), Not(HasSubstr(secret)));
  }
}

// A daemon that requires client certificates, which HTTP does not have.
class ApiCertificatesTest : public ApiTest {
 protected:
  ApiCertificatesTest() { options_.tls.ca = "unused without a certificate"; }
};

TEST_F(ApiCertificatesTest, HttpRequiresAToken) {
  EXPECT_THAT(Get("/api/whoami").body, HasSubstr(R"("asksForTokens":true,"loggedIn":false)"));
  EXPECT_EQ(Call(kList, "{}").status, 401);
  EXPECT_EQ(Get("/events/sweepstake.v1.PosteriorsService/WatchPosteriors").status, 401);
  EXPECT_EQ(Post("/login", R"({"token":"x"})").status, 401);
  grpc::ClientContext context;
  v1::ListPosteriorsResponse response;
  EXPECT_TRUE(
      v1::PosteriorsService::NewStub(channel_)->ListPosteriors(&context, {}, &response).ok());
}

}  // namespace
}  // namespace sweepstake::server
