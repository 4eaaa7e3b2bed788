// Tests the decoding of a request's query.
#include "server/web/query.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::web {
namespace {

TEST(QueryTest, AValueIsDecoded) {
  EXPECT_EQ(*QueryValue("request=%7b%22a%22%3A1%7D", "request"), "{\"a\":1}");
  EXPECT_EQ(*QueryValue("a=1&request=x+y%2B&request=z", "request"), "x y+");
  EXPECT_EQ(*QueryValue("request=a=b", "request"), "a=b");
  EXPECT_EQ(*QueryValue("request=%00", "request"), std::string(1, '\0'));
}

TEST(QueryTest, AnAbsentValueIsEmpty) {
  for (const char* query : {"", "&", "=", "request", "requests=1", "Request=1", "a=request="})
    EXPECT_EQ(*QueryValue(query, "request"), "") << query;
}

TEST(QueryTest, APercentSignNeedsTwoDigits) {
  for (const char* query : {"request=%", "request=%1", "request=%1g", "request=%g1", "request=a%",
                            "request=%-1", "request=% 1", "request=%1&a=2"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(QueryValue(query, "request").status())) << query;
  }
}

}  // namespace
}  // namespace sweepstake::web
