#include "engine_client/cli/io/text_table.h"

#include <gtest/gtest.h>

#include <sstream>

namespace sweepstake::cli {
namespace {

TEST(TextTable, AlignsNumbersRightAndWordsLeft) {
  TextTable table({"arm", "ms"});
  table.AddRow({"SAP", "0.5"});
  table.AddRow({"KDTree", "12.25"});
  EXPECT_EQ(table.Text(),
            "arm        ms\n"
            "SAP       0.5\n"
            "KDTree  12.25\n");
}

TEST(TextTable, AColumnWithOneWordIsAlignedLeft) {
  TextTable table({"n", "x"});
  table.AddRow({"1", "a"});
  table.AddRow({"-", "a"});
  table.AddRow({"none", "a"});
  EXPECT_EQ(table.Text(), "n     x\n1     a\n-     a\nnone  a\n");
}

TEST(TextTable, CountsCharactersAndNotBytes) {
  TextTable table({"a", "b"});
  table.AddRow({"→→", "x"});
  table.AddRow({"abc", "y"});
  EXPECT_EQ(table.Text(), "a    b\n→→   x\nabc  y\n");
}

TEST(TextTable, ATitleSpansTheColumnsAndWidensNone) {
  TextTable table({"a", "b"});
  table.AddTitle("a long title");
  table.AddRow({"1", "2"});
  EXPECT_EQ(table.Text(), "a  b\n\na long title\n1  2\n");
}

TEST(TextTable, WithoutRowsIsItsHeader) {
  const TextTable table({"arm", "ms"});
  EXPECT_EQ(table.Text(), "arm  ms\n");
  std::ostringstream out;
  table.Print(out);
  EXPECT_EQ(out.str(), table.Text());
}

TEST(TextTable, LeavesNoSpaceAtTheEndOfALine) {
  TextTable table({"a", "long header"});
  table.AddRow({"x", "y"});
  EXPECT_EQ(table.Text(), "a  long header\nx  y\n");
}

TEST(Fixed, RoundsToTheDecimals) {
  EXPECT_EQ(Fixed(0.125, 2), "0.12");
  EXPECT_EQ(Fixed(2.5, 0), "2");
  EXPECT_EQ(Fixed(3.5, 0), "4");
  EXPECT_EQ(Fixed(-1.005, 1), "-1.0");
  EXPECT_EQ(Fixed(1e6, 3), "1000000.000");
  EXPECT_EQ(Fixed(-2.78e-17, 2), "0.00");
  EXPECT_EQ(Fixed(-0.4, 0), "0");
}

TEST(LetterCount, CountsCharacters) {
  EXPECT_EQ(LetterCount(""), 0U);
  EXPECT_EQ(LetterCount("a · →"), 5U);
}

}  // namespace
}  // namespace sweepstake::cli
