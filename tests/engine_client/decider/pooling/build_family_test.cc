#include "engine_client/decider/pooling/build_family.h"

#include <gtest/gtest.h>

#include <vector>

namespace sweepstake::decision {
namespace {

priors::Build Build(const std::string& name, const std::vector<std::string>& parents) {
  return {.project = "game", .name = name, .parents = parents, .unix_made_s = 0};
}

TEST(BuildFamily, EachStepCountsLess) {
  const std::vector<priors::Build> builds = {Build("2", {"1"}), Build("3", {"2"}),
                                             Build("sister", {"2"}), Build("4", {"3"}),
                                             Build("merge", {"3", "sister"})};
  const BuildFamily family("3", builds);
  EXPECT_DOUBLE_EQ(family.WeightOf("3"), 0.5);
  EXPECT_DOUBLE_EQ(family.WeightOf("2"), 0.4) << "its parent";
  EXPECT_DOUBLE_EQ(family.WeightOf("4"), 0.4) << "its child";
  EXPECT_DOUBLE_EQ(family.WeightOf("1"), 0.32);
  EXPECT_DOUBLE_EQ(family.WeightOf("sister"), 0.32);
  EXPECT_DOUBLE_EQ(family.WeightOf("stranger"), 0.125);
  EXPECT_DOUBLE_EQ(family.WeightOf(""), 0.125) << "of an unknown build";
}

TEST(BuildFamily, ADistantRelativeCountsAsMuchAsAStranger) {
  std::vector<priors::Build> builds;
  for (int i = 1; i < 20; ++i) builds.push_back(Build(std::to_string(i), {std::to_string(i - 1)}));
  const BuildFamily family("19", builds);
  EXPECT_DOUBLE_EQ(family.WeightOf("0"), 0.125);
  EXPECT_DOUBLE_EQ(family.WeightOf("13"), 0.5 * 0.8 * 0.8 * 0.8 * 0.8 * 0.8 * 0.8);
}

TEST(BuildFamily, WhereNothingWasSaidAllOthersCountAlike) {
  const BuildFamily family("3");
  EXPECT_DOUBLE_EQ(family.WeightOf("3"), 0.5);
  EXPECT_DOUBLE_EQ(family.WeightOf("2"), 0.25);
  EXPECT_DOUBLE_EQ(family.WeightOf(""), 0.25);
  const std::vector<priors::Build> alone = {Build("3", {})};
  EXPECT_DOUBLE_EQ(BuildFamily("3", alone).WeightOf("2"), 0.25) << "made from none";
}

TEST(BuildFamily, GoesRoundOnce) {
  const std::vector<priors::Build> builds = {Build("1", {"2"}), Build("2", {"1"})};
  EXPECT_DOUBLE_EQ(BuildFamily("1", builds).WeightOf("2"), 0.4);
}

}  // namespace
}  // namespace sweepstake::decision
