// Tests the paths of the HTTP side, and which requests may use them.
#include "server/web/site.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "tests/server/web/fake_exchange.h"

namespace sweepstake::web {
namespace {

using boost::beast::http::verb;
using Headers = FakeExchange::Headers;
using ::testing::HasSubstr;

class SiteTest : public ::testing::Test {
 protected:
  Page Ask(verb method, const std::string& target, const Headers& headers = {}) {
    const auto exchange = std::make_shared<FakeExchange>(method, target, headers);
    site_.Handle(exchange);
    return exchange->answer();
  }
  int Status(verb method, const std::string& target, const Headers& headers = {}) {
    return Ask(method, target, headers).status;
  }
  // Sends a POST of the daemon's own page to the API, with these additional headers.
  int Post(const Headers& more, const std::string& target = "/api/x") {
    Headers headers = FakeExchange::OfPage();
    headers.insert(headers.end(), more.begin(), more.end());
    return Status(verb::post, target, headers);
  }

  static constexpr int kOfApi = 299;
  Site site_{{.pages = {{"/livez",
                         [](std::string_view query) { return Page{.body = std::string(query)}; }}},
              .hosts = {"dash.example.com"},
              .files = DashboardFiles({}, "there is no dashboard"),
              .api = [](const std::shared_ptr<Exchange>& exchange) {
                exchange->Answer({.status = kOfApi});
              }}};
};

TEST_F(SiteTest, APageIsMadeFromTheQueryWhateverTheHost) {
  EXPECT_EQ(Ask(verb::get, "/livez?verbose", {{"Host", "evil.example"}}).body, "verbose");
  EXPECT_EQ(Ask(verb::head, "/livez").status, 200);
  EXPECT_EQ(Status(verb::post, "/livez", FakeExchange::OfPage()), 405);
}

TEST_F(SiteTest, OtherMethodsAreRefusedWithThoseOfThePath) {
  const std::pair<const char*, const char*> methods_of[] = {
      {"/livez", "GET, HEAD"}, {"/", "GET, HEAD"}, {"/login", "GET, HEAD, POST"}};
  for (const verb method : {verb::put, verb::delete_, verb::options, verb::trace, verb::connect}) {
    for (const auto& [path, methods] : methods_of) {
      const Page page = Ask(method, path, FakeExchange::OfPage());
      EXPECT_EQ(page.status, 405) << method << " " << path;
      EXPECT_EQ(page.headers.at(0).second, methods) << path;
    }
    for (const char* const path : {"/api/x", "/events/x", "/logout"})
      EXPECT_EQ(Status(method, path, FakeExchange::OfPage()), kOfApi) << path;
  }
  EXPECT_EQ(Status(verb::post, "/", FakeExchange::OfPage()), 405);
  EXPECT_EQ(Status(verb::get, "http://localhost/livez"), 400);
}

TEST_F(SiteTest, NoPathLeadsToTheFileSystem) {
  for (const char* path : {"/etc/passwd", "/../etc/passwd", "/%2e%2e/etc/passwd", "/livez/",
                           "//livez", "/assets/", "/index", "/scenes.html"}) {
    EXPECT_EQ(Status(verb::get, path), 404) << path;
  }
}

TEST_F(SiteTest, TheDashboardIsAtThePathsOfItsPages) {
  for (const char* path : {"/", "/scenes", "/scenes/arcade/arena", "/sessions/17", "/decisions",
                           "/priors", "/health?a=b", "/login"}) {
    EXPECT_EQ(Ask(verb::get, path).body, "there is no dashboard\n") << path;
  }
}

TEST_F(SiteTest, TheDaemonAnswersToItsOwnNamesOnly) {
  for (const char* host :
       {"localhost", "localhost:7434", "LOCALHOST", "127.0.0.1:1", "127.1.2.3", "[::1]:7434",
        "192.0.2.1:7434", "dash.example.com", "Dash.Example.com:80"}) {
    EXPECT_EQ(Status(verb::get, "/", {{"Host", host}}), 200) << host;
    EXPECT_EQ(Post({{"Host", host}}), kOfApi) << host;
  }
  for (const char* host :
       {"evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "", "192.0.2.2",
        "[::2]", "[", ":", "dash.example.com.", "dash.example.comx", "localhost:80.evil.example",
        "[::1].evil.example", "[::1]:80.evil.example", "localhost:-1"}) {
    EXPECT_EQ(Status(verb::get, "/", {{"Host", host}}), 403) << host;
    EXPECT_EQ(Post({{"Host", host}}), 403) << host;
    EXPECT_EQ(Status(verb::get, "/events/x", {{"Host", host}}), 403) << host;
  }
}

TEST_F(SiteTest, TwoHostsAreRefused) {
  const auto exchange = std::make_shared<FakeExchange>(verb::get, "/");
  exchange->mutable_request().message.insert("Host", "evil.example");
  site_.Handle(exchange);
  EXPECT_EQ(exchange->answer().status, 403);
}

TEST_F(SiteTest, TheApiHasItsPaths) {
  EXPECT_EQ(Status(verb::get, "/api/whoami"), kOfApi);
  EXPECT_EQ(Status(verb::get, "/events/x?request={}"), kOfApi);
  for (const char* path : {"/api/x", "/login", "/logout"})
    EXPECT_EQ(Post({}, path), kOfApi) << path;
}

TEST_F(SiteTest, APostOfAnotherSitesPageIsRefused) {
  EXPECT_EQ(Status(verb::post, "/api/x"), 403) << "a form cannot set a header";
  EXPECT_EQ(Status(verb::post, "/login"), 403);
  EXPECT_EQ(Status(verb::post, "/api/x", {{"X-Sweepstake", "0"}}), 403);
  EXPECT_EQ(Post({{"Origin", "http://localhost"}}), kOfApi);
  EXPECT_EQ(Post({{"Origin", "https://dash.example.com"}, {"Host", "dash.example.com"}}), kOfApi);
  for (const char* origin : {"http://evil.example", "null", "http://localhost:1", "localhost",
                             "http://localhost.evil.example"}) {
    EXPECT_EQ(Post({{"Origin", origin}}), 403) << origin;
  }
}

TEST_F(SiteTest, ARequestThatABrowserMarksAsCrossSiteIsRefused) {
  for (const char* site : {"cross-site", "same-site"}) {
    EXPECT_EQ(Post({{"Sec-Fetch-Site", site}}), 403);
    EXPECT_EQ(Status(verb::get, "/events/x", {{"Sec-Fetch-Site", site}}), 403);
    EXPECT_EQ(Status(verb::get, "/", {{"Sec-Fetch-Site", site}}), 200) << "a link to the dashboard";
  }
  EXPECT_EQ(Status(verb::get, "/events/x", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(Post({{"Sec-Fetch-Site", "same-origin"}}), kOfApi);
  EXPECT_THAT(Ask(verb::post, "/api/x").body,
              HasSubstr("{\"error\":{\"code\":\"PERMISSION_DENIED\""));
}

}  // namespace
}  // namespace sweepstake::web
