#include "engine_client/text/names.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

namespace sweepstake::text {
namespace {

constexpr std::array<std::string_view, 4> kFruits = {"apple", "banana", "pear", "peach"};

TEST(Names, ArePrintableUtf8UpToTheMaximumLength) {
  EXPECT_TRUE(IsName("Hurricane <3> \"x\"; DROP TABLE"));
  EXPECT_TRUE(IsName("\xC3\xA4\xE2\x82\xAC\xF0\x9F\x8C\x80"));
  EXPECT_TRUE(IsName(std::string(128, 'x')));
  EXPECT_FALSE(IsName(std::string(129, 'x')));
  EXPECT_FALSE(IsName(""));
  EXPECT_TRUE(IsOptionalName(""));
  EXPECT_FALSE(IsOptionalName(std::string(129, 'x')));
}

TEST(Names, ContainNoControlCharactersAndNoInvalidUtf8) {
  using namespace std::string_view_literals;
  for (const std::string_view broken :
       {"a\0b"sv, "\x1F"sv, "\x7F"sv, "\xC2\x85"sv, "\x80"sv, "\xC3"sv, "\xC0\xAF"sv,
        "\xE0\x80\xAF"sv, "\xED\xA0\x80"sv, "\xF4\x90\x80\x80"sv, "\xF5\x80\x80\x80"sv,
        "\xE2\x28\xA1"sv}) {
    EXPECT_FALSE(IsName(broken)) << ::testing::PrintToString(broken);
  }
}

TEST(Names, TheNearestNameNeedsTheFewestEdits) {
  EXPECT_EQ(NearestName("peer", kFruits), "pear");
  EXPECT_EQ(NearestName("bananas", kFruits), "banana");
  EXPECT_EQ(NearestName("pple", kFruits), "apple");
  EXPECT_EQ(NearestName("anything", {}), "");
}

TEST(Names, TheFirstOfEquallyNearNamesIsChosen) {
  constexpr std::array<std::string_view, 2> names = {"ab", "ac"};
  EXPECT_EQ(NearestName("ad", names), "ab");
}

TEST(Names, AnUnknownNameListsTheNearestFirstAndEveryOtherOnce) {
  EXPECT_EQ(UnknownName("fruit", "peach\n", kFruits),
            "unknown fruit 'peach?', must be one of peach, apple, banana, pear");
}

TEST(Names, AnUnknownNameOfManyListsOnlyTheNearest) {
  EXPECT_EQ(UnknownNameOfMany("fruit", "peach\n", kFruits),
            "unknown fruit 'peach?', the nearest is peach; --help lists all");
  constexpr std::string_view kNear[] = {"bat", "boat", "cat", "hat", "rat"};
  EXPECT_EQ(UnknownNameOfMany("animal", "xat", kNear),
            "unknown animal 'xat', the nearest are bat, cat, hat; --help lists all");
}

TEST(Names, ALineHasNoControlCharactersAndAtMost200Bytes) {
  EXPECT_EQ(PrintableLine("a\tb\x7f\xc3"), "a?b??");
  EXPECT_EQ(PrintableLine(std::string(1000, 'x')), std::string(200, 'x'));
}

TEST(PrintableLines, KeepsTextAndRemovesWhatCouldControlATerminal) {
  EXPECT_EQ(PrintableLines("a\nf\u00fcr \u6e2f\n"), "a\nf\u00fcr \u6e2f\n");
  EXPECT_EQ(PrintableLines("\x1b[2J\a\r\x7f"), "?[2J???");
  EXPECT_EQ(PrintableLines("\xc2\x9b"
                           "31m"),
            "??31m")
      << "a control character above 127";
  EXPECT_EQ(PrintableLines("\xff\xe6\xb8"), "???") << "not UTF-8";
  EXPECT_EQ(PrintableLines(std::string(300, 'x')).size(), 300u);
}

}  // namespace
}  // namespace sweepstake::text
