#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sweepstake/broad_phase.h"

namespace sweepstake {
namespace {

TEST(Registry, ListsTheSevenFamiliesInThePapersOrder) {
  EXPECT_THAT(BroadPhaseNames(), testing::ElementsAre("BruteForce", "Grid", "SAP", "AxisSweep",
                                                      "DBVT", "Tracy", "KDTree"));
}

TEST(Registry, MakesEachListedBackend) {
  for (const std::string_view name : BroadPhaseNames()) {
    auto made = MakeBroadPhase(name);
    ASSERT_TRUE(made.ok()) << name;
    EXPECT_EQ((*made)->name(), name);
  }
}

TEST(Registry, ListsTheValidNamesForAnUnknownOne) {
  for (const std::string_view name : {"", "Quadtree", "sap", "SAP "}) {
    const auto made = MakeBroadPhase(name);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.status().code(), StatusCode::kNotFound);
    for (const std::string_view valid : BroadPhaseNames()) {
      EXPECT_THAT(made.status().message(), testing::HasSubstr(std::string(valid)));
    }
  }
}

}  // namespace
}  // namespace sweepstake
