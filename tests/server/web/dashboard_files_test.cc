// Tests the files of the dashboard as browsers receive them.
#include "server/web/dashboard_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "tests/server/web/fake_exchange.h"

namespace sweepstake::web {
namespace {

using ::testing::Contains;
using ::testing::Pair;

// The output of `printf 'hello hello hello hello\n' | gzip -n9`.
constexpr unsigned char kGzip[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03,
                                   0xcb, 0x48, 0xcd, 0xc9, 0xc9, 0x57, 0xc8, 0x40, 0x27, 0xb9,
                                   0x00, 0x00, 0x88, 0x59, 0x0b, 0x18, 0x00, 0x00, 0x00};

class DashboardFilesTest : public ::testing::Test {
 protected:
  Page Ask(const std::string& target, const FakeExchange::Headers& headers = {}) {
    const FakeExchange exchange(boost::beast::http::verb::get, target, headers);
    return files_.PageFor(exchange.request());
  }

  const std::string gzip_{reinterpret_cast<const char*>(kGzip), sizeof kGzip};
  const std::array<DashboardAsset, 2> assets_ = {{
      {"/assets/main-1f2e.js", "text/javascript", gzip_, "\"1f2e\"", true},
      {"/index.html", "text/html; charset=utf-8", gzip_, "\"cafe\"", false},
  }};
  const DashboardFiles files_{assets_, ""};
};

TEST_F(DashboardFilesTest, AFileIsAtItsPathAndThePagesHaveTheIndex) {
  const FakeExchange::Headers gzip = {{"Accept-Encoding", "br, gzip"}};
  for (const char* path : {"/", "/index.html", "/decisions?range=1h", "/health", "/recording"}) {
    const Page page = Ask(path, gzip);
    EXPECT_EQ(page.content_type, "text/html; charset=utf-8") << path;
    EXPECT_EQ(page.body, "hello hello hello hello\n");
    EXPECT_THAT(page.headers, Contains(Pair("Vary", "Accept-Encoding")));
    EXPECT_THAT(page.headers, Contains(Pair("Cache-Control", "no-cache")));
  }
  const Page script = Ask("/assets/main-1f2e.js", gzip);
  EXPECT_EQ(script.content_type, "text/javascript");
  EXPECT_EQ(script.body, gzip_);
  EXPECT_THAT(script.headers, Contains(Pair("Content-Encoding", "gzip")));
  EXPECT_THAT(script.headers,
              Contains(Pair("Cache-Control", "public, max-age=31536000, immutable")));
  EXPECT_EQ(Ask("/assets/main-0000.js").status, 404);
}

TEST_F(DashboardFilesTest, AClientWithoutGzipReceivesTheUncompressedFile) {
  const Page page = Ask("/assets/main-1f2e.js");
  EXPECT_EQ(page.body, "hello hello hello hello\n");
  EXPECT_THAT(page.headers, ::testing::Not(Contains(Pair("Content-Encoding", "gzip"))));
}

TEST_F(DashboardFilesTest, AFileThatABrowserHasIsNotSentAgain) {
  const Page page = Ask("/", {{"If-None-Match", "\"beef\", W/\"cafe\""}});
  EXPECT_EQ(page.status, 304);
  EXPECT_EQ(page.body, "");
  EXPECT_THAT(page.headers, Contains(Pair("ETag", "\"cafe\"")));
  EXPECT_EQ(Ask("/", {{"If-None-Match", "\"beef\""}}).status, 200);
}

// The output of
// `printf '<meta property="og:title" content="Sweepstake">\n<title>x</title>\n' | gzip -n9`.
constexpr unsigned char kTitledGzip[] = {
    0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0xb3, 0xc9, 0x4d, 0x2d, 0x49, 0x54,
    0x28, 0x28, 0xca, 0x2f, 0x48, 0x2d, 0x2a, 0xa9, 0xb4, 0x55, 0xca, 0x4f, 0xb7, 0x2a, 0xc9, 0x2c,
    0xc9, 0x49, 0x55, 0x52, 0x48, 0xce, 0xcf, 0x2b, 0x49, 0xcd, 0x2b, 0xb1, 0x55, 0x0a, 0x2e, 0x4f,
    0x4d, 0x2d, 0x28, 0x2e, 0x49, 0xcc, 0x4e, 0x55, 0xb2, 0xe3, 0xb2, 0x01, 0xcb, 0xda, 0x55, 0xd8,
    0xe8, 0x43, 0x18, 0x5c, 0x00, 0x8b, 0xbd, 0x6d, 0x59, 0x41, 0x00, 0x00, 0x00};

std::string Titled(const std::string& title) {
  return "<meta property=\"og:title\" content=\"" + title + "\">\n<title>x</title>\n";
}

// Returns the body of the page at the target, for a client that accepts gzip.
std::string TitledBody(const std::string& target) {
  const std::string gzip(reinterpret_cast<const char*>(kTitledGzip), sizeof kTitledGzip);
  const std::array<DashboardAsset, 1> assets = {
      {{"/index.html", "text/html", gzip, "\"cafe\"", false}}};
  const FakeExchange exchange(boost::beast::http::verb::get, target, {{"Accept-Encoding", "gzip"}});
  const Page page = DashboardFiles(assets, "").PageFor(exchange.request());
  return page.body == Titled("Sweepstake") ? "as it is" : page.body;
}

TEST(DashboardLinks, AreTitledByTheNamesInTheirPaths) {
  EXPECT_EQ(TitledBody("/scenes/game/%e6%b8%af%20x?class=a"),
            Titled("game / \u6e2f x \u00b7 Sweepstake"));
  EXPECT_EQ(TitledBody("/scenes/~.a/~~b"), Titled(".a / ~b \u00b7 Sweepstake"));
  EXPECT_EQ(TitledBody("/sessions/5e55"), Titled("5e55 \u00b7 Sweepstake"));
  for (const char* nameless : {"/", "/scenes", "/scenes/a", "/scenes/a/b/c", "/sessions", "/priors",
                               "/decisions?session=a", "/health/a/b"})
    EXPECT_EQ(TitledBody(nameless), "as it is") << nameless;
}

// The output of
// `printf '<link href="./assets/a.css"><script src="./assets/a.js"></script>\n' | gzip -n9`.
constexpr unsigned char kLinkingGzip[] = {
    0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0xb3, 0xc9, 0xc9, 0xcc,
    0xcb, 0x56, 0xc8, 0x28, 0x4a, 0x4d, 0xb3, 0x55, 0xd2, 0xd3, 0x4f, 0x2c, 0x2e, 0x4e,
    0x2d, 0x29, 0xd6, 0x4f, 0xd4, 0x4b, 0x2e, 0x2e, 0x56, 0xb2, 0xb3, 0x29, 0x4e, 0x2e,
    0xca, 0x2c, 0x28, 0x51, 0x28, 0x2e, 0x4a, 0x46, 0x91, 0xcc, 0x02, 0xc9, 0xe9, 0x43,
    0x24, 0xed, 0xb8, 0x00, 0x79, 0xeb, 0x9e, 0x14, 0x42, 0x00, 0x00, 0x00};

TEST(DashboardLinks, BeginWithTheBasePath) {
  const std::string gzip(reinterpret_cast<const char*>(kLinkingGzip), sizeof kLinkingGzip);
  const std::array<DashboardAsset, 1> assets = {
      {{"/index.html", "text/html", gzip, "\"cafe\"", false}}};
  const DashboardFiles files(assets, "");
  FakeExchange exchange(boost::beast::http::verb::get, "/health",
                        {{"If-None-Match", "\"cafe/tools/sweepstake\""}});
  Page page = files.PageFor(exchange.request());
  EXPECT_EQ(page.body, "<link href=\"/assets/a.css\"><script src=\"/assets/a.js\"></script>\n");
  exchange.mutable_request().base_path = "/tools/sweepstake";
  EXPECT_EQ(files.PageFor(exchange.request()).status, 304);
  exchange.mutable_request().message.erase("If-None-Match");
  page = files.PageFor(exchange.request());
  EXPECT_EQ(page.body,
            "<link href=\"/tools/sweepstake/assets/a.css\">"
            "<script src=\"/tools/sweepstake/assets/a.js\"></script>\n");
  EXPECT_THAT(page.headers, Contains(Pair("ETag", "\"cafe/tools/sweepstake\"")));
}

TEST(DashboardLinks, AHostileNameIsEscapedOrOmitted) {
  EXPECT_EQ(TitledBody("/scenes/%22%3E%3Cscript%3E/'%26amp;"),
            Titled("&quot;&gt;&lt;script&gt; / &#39;&amp;amp; \u00b7 Sweepstake"));
  EXPECT_EQ(TitledBody("/sessions/\"><b>"), Titled("&quot;&gt;&lt;b&gt; \u00b7 Sweepstake"));
  for (const char* hostile :
       {"/sessions/%", "/sessions/%zz", "/sessions/%00", "/sessions/a%0ab", "/sessions/%ff",
        "/sessions/", "/scenes//a", "/scenes/a/", "/sessions/a%e2%80%aeb", "/sessions/%e2%81%a6",
        "/sessions/%d8%9c", "/sessions/%ef%bb%bf", "/sessions/%e2%80%8b", "/sessions/~"})
    EXPECT_EQ(TitledBody(hostile), "as it is") << hostile;
  EXPECT_EQ(TitledBody("/sessions/" + std::string(129, 'x')), "as it is");
  EXPECT_EQ(TitledBody("/sessions/%e2%80%93%e2%81%84"), Titled("\u2013\u2044 \u00b7 Sweepstake"));
}

TEST(DashboardFiles, WithoutFilesThePagesStateTheReason) {
  const DashboardFiles none({}, "build it with Node");
  const FakeExchange page(boost::beast::http::verb::get, "/scenes");
  EXPECT_EQ(none.PageFor(page.request()).body, "build it with Node\n");
  const FakeExchange file(boost::beast::http::verb::get, "/assets/main.js");
  EXPECT_EQ(none.PageFor(file.request()).status, 404);
}

}  // namespace
}  // namespace sweepstake::web
