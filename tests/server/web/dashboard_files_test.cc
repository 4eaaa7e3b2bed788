// The dashboard's files as browsers get them.
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

// What `printf 'hello hello hello hello\n' | gzip -n9` makes.
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
  for (const char* path : {"/", "/index.html", "/scenes/a/b?range=1h", "/health"}) {
    const Page page = Ask(path, gzip);
    EXPECT_EQ(page.content_type, "text/html; charset=utf-8") << path;
    EXPECT_EQ(page.body, gzip_);
    EXPECT_THAT(page.headers, Contains(Pair("Content-Encoding", "gzip")));
    EXPECT_THAT(page.headers, Contains(Pair("Vary", "Accept-Encoding")));
    EXPECT_THAT(page.headers, Contains(Pair("Cache-Control", "no-cache")));
  }
  const Page script = Ask("/assets/main-1f2e.js", gzip);
  EXPECT_EQ(script.content_type, "text/javascript");
  EXPECT_THAT(script.headers,
              Contains(Pair("Cache-Control", "public, max-age=31536000, immutable")));
  EXPECT_EQ(Ask("/assets/main-0000.js").status, 404);
}

TEST_F(DashboardFilesTest, WhoTakesNoGzipGetsTheFileAsItIs) {
  const Page page = Ask("/");
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

TEST(DashboardFiles, WithoutFilesThePagesSayWhy) {
  const DashboardFiles none({}, "build it with Node");
  const FakeExchange page(boost::beast::http::verb::get, "/scenes");
  EXPECT_EQ(none.PageFor(page.request()).body, "build it with Node\n");
  const FakeExchange file(boost::beast::http::verb::get, "/index.html");
  EXPECT_EQ(none.PageFor(file.request()).status, 404);
}

}  // namespace
}  // namespace sweepstake::web
