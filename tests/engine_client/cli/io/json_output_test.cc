#include "engine_client/cli/io/json_output.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

TEST(PrintJson, ReplacesBytesThatAreNotUtf8) {
  std::ostringstream out;
  PrintJson({{"scene", "a\xff"}}, out, -1);
  EXPECT_EQ(out.str(), "{\"scene\":\"a\uFFFD\"}\n");
}

TEST(PrintJson, KeepsTheOrderOfTheFieldsAndIndents) {
  std::ostringstream out;
  PrintJson({{"z", 1}, {"a", Json::array()}}, out);
  EXPECT_EQ(out.str(), "{\n  \"z\": 1,\n  \"a\": []\n}\n");
}

TEST(PrintResult, PrintsEitherTheDocumentOrTheText) {
  for (const bool as_json : {false, true}) {
    std::ostringstream out;
    std::ostringstream err;
    Terminal terminal{.out = out, .err = err};
    PrintResult(terminal, as_json, {{"a", 1}}, "one line\n");
    EXPECT_EQ(out.str(), as_json ? "{\n  \"a\": 1\n}\n" : "one line\n");
    EXPECT_EQ(err.str(), "");
  }
}

}  // namespace
}  // namespace sweepstake::cli
