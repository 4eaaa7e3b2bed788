#include "engine_client/cli/io/screen.h"

#include <gtest/gtest.h>

#include <sstream>

namespace sweepstake::cli {
namespace {

TEST(ScreenGrid, CutsTextAtItsEdgesAndDropsSpacesAtTheEndsOfRows) {
  ScreenGrid grid({.columns = 4, .rows = 2});
  grid.Put(0, 1, "×→⣿abc");
  grid.Put(1, 0, "a ");
  grid.Put(2, 0, "below");
  grid.Put(0, 9, "beside");
  EXPECT_EQ(grid.Text(true), " ×→⣿\na");
}

TEST(ScreenGrid, WritesAColourOnlyWhereItChanges) {
  ScreenGrid grid({.columns = 6, .rows = 2});
  grid.Put(0, 0, "a b", 39);
  grid.Put(0, 3, "c", 208);
  grid.Put(1, 0, "d", 208);
  grid.Put(1, 1, "e");
  EXPECT_EQ(grid.Text(true), "\x1b[38;5;39ma b\x1b[38;5;208mc\nd\x1b[39me");
  EXPECT_EQ(grid.Text(false), "a bc\nde");
}

TEST(ScreenGrid, EndsWithTheDefaultColour) {
  ScreenGrid grid({.columns = 1, .rows = 1});
  grid.Put(0, 0, "a", 39);
  EXPECT_EQ(grid.Text(true), "\x1b[38;5;39ma\x1b[39m");
}

TEST(ScreenGrid, ReplacesControlCharacters) {
  ScreenGrid grid({.columns = 9, .rows = 1});
  grid.Put(0, 0, "a\x1b[2J\n\x7f");
  EXPECT_EQ(grid.Text(true), "a?[2J??");
}

TEST(FullScreen, ClearsWhatTheTextDoesNotCoverAndRestoresTheTerminal) {
  std::ostringstream out;
  {
    FullScreen screen(out);
    EXPECT_EQ(out.str(), "\x1b[?1049h\x1b[?25l");
    out.str("");
    screen.Draw("ab\nc");
    EXPECT_EQ(out.str(), "\x1b[Hab\x1b[K\nc\x1b[K\x1b[J");
    out.str("");
  }
  EXPECT_EQ(out.str(), "\x1b[?25h\x1b[?1049l");
}

}  // namespace
}  // namespace sweepstake::cli
