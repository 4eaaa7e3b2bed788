// Tests the compression of answers: what is compressed, and that zlib reads it back.
#include "server/web/gzip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/web/fake_exchange.h"
#include "tests/server/web/gunzip.h"

namespace sweepstake::web {
namespace {

using test_support::Gunzip;
using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Pair;

bool Accepts(const std::string& encodings) {
  return AcceptsGzip(
      FakeExchange(boost::beast::http::verb::get, "/", {{"Accept-Encoding", encodings}}).request());
}

TEST(GzipTest, AClientAcceptsGzipUnlessItsWeightIsZero) {
  for (const char* encodings : {"gzip", "br, gzip", "deflate, GZIP;q=0.5 , br", "gzip; q=1"})
    EXPECT_TRUE(Accepts(encodings)) << encodings;
  for (const char* encodings :
       {"", "br", "gzip;q=0", "gzip; q=0.0", "gzipped", "xgzip", "gzip;q=x"})
    EXPECT_FALSE(Accepts(encodings)) << encodings;
}

std::string LongText() {
  std::string text;
  for (int i = 0; i < 10'000; ++i) text += "row " + std::to_string(i * i) + "\n";
  return text;
}

TEST(GzipTest, ALongTextIsCompressedAndReadBack) {
  for (const char* type : {"text/csv", "application/json", "application/x-ndjson"}) {
    Page page{.body = LongText(), .content_type = type};
    Compress(page);
    EXPECT_THAT(page.headers, Contains(Pair("Content-Encoding", "gzip")));
    EXPECT_LT(page.body.size(), LongText().size() / 3);
    EXPECT_EQ(Gunzip(page.body), LongText());
  }
}

TEST(GzipTest, AShortOrCompressedOrOtherBodyStays) {
  Page shorter{.body = std::string(1023, 'a')};
  Page picture{.body = LongText(), .content_type = "image/png"};
  for (Page* page : {&shorter, &picture}) {
    const std::string body = page->body;
    Compress(*page);
    EXPECT_EQ(page->body, body);
    EXPECT_THAT(page->headers, IsEmpty());
  }
  Page compressed{.body = LongText(), .headers = {{"Content-Encoding", "gzip"}}};
  Compress(compressed);
  EXPECT_EQ(compressed.body, LongText());
}

TEST(GzipTest, EachPartCanBeReadBeforeTheNext) {
  GzipWriter writer;
  std::string sent;
  std::string expected;
  for (const std::string& part : {std::string("a"), LongText(), std::string("\0\xff", 2)}) {
    sent += writer.Write(part, /*is_last=*/false);
    expected += part;
    EXPECT_EQ(Gunzip(sent), expected);
  }
  sent += writer.Write("", /*is_last=*/true);
  EXPECT_EQ(Gunzip(sent), expected);
}

}  // namespace
}  // namespace sweepstake::web
