#include "tests/laboratory/experiment/paper_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sweepstake::cli {
namespace {

TEST(PaperTables, HaveNineCellsWhoseTwoTablesAgree) {
  EXPECT_EQ(PaperCells().size(), 9U);
  for (const PaperCell& cell : PaperCells()) {
    const std::string leader = std::string(cell.dominant) + " " +
                               std::to_string(cell.dominant_run_count) + "/" +
                               std::to_string(kPaperRunCount);
    EXPECT_THAT(std::string(cell.dominance), testing::StartsWith(leader));
    EXPECT_EQ(FindPaperCell(cell.scene, cell.object_count), &cell);
  }
  EXPECT_EQ(FindPaperCell("hurricane", 4000), nullptr);
}

}  // namespace
}  // namespace sweepstake::cli
