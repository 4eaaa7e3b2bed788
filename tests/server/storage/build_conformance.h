// What every prior store must keep and find of what builds were made from.
// Whoever includes prior_store_conformance.h includes it, too.
#pragma once

#include <string>
#include <vector>

#include "tests/server/storage/prior_store_conformance.h"

namespace sweepstake::storage {

class BuildConformance : public PriorStoreConformance {
 protected:
  static priors::Build Build(const std::string& name, const std::vector<std::string>& parents,
                             const std::string& project = "game") {
    return {.project = project, .name = name, .parents = parents, .unix_made_s = 0};
  }
  absl::Status Describe(const std::vector<priors::Build>& builds) {
    return store_->DescribeBuilds(builds);
  }
  std::vector<std::string> Family(const std::string& build) {
    std::vector<std::string> names;
    for (const priors::Build& one : *store_->LoadFamily("game", build)) names.push_back(one.name);
    return names;
  }
};

TEST_P(BuildConformance, OfABuildItHasWhatWasSaidLast) {
  ASSERT_TRUE(Describe({Build("2", {"1", "1-fix"})}).ok());
  priors::Build again = Build("2", {"1"});
  again.unix_made_s = 1'760'000'000;
  ASSERT_TRUE(Describe({again, Build("1", {})}).ok());
  EXPECT_THAT(*store_->ListBuilds({}, {}, 10), ::testing::ElementsAre(Build("1", {}), again));
}

TEST_P(BuildConformance, AFamilyIsABuildItsAncestorsAndWhatWasMadeOfThese) {
  ASSERT_TRUE(Describe({Build("1", {}), Build("2", {"1"}), Build("3", {"2", "fix"}),
                        Build("fix", {"1"}), Build("sister", {"2"}), Build("niece", {"sister"}),
                        Build("4", {"3"}), Build("5", {"4"}), Build("stranger", {"elsewhere"}),
                        Build("3", {"1"}, "other game")})
                  .ok());
  EXPECT_THAT(Family("3"), ::testing::ElementsAre("1", "2", "3", "fix", "4", "sister"));
  EXPECT_THAT(Family("elsewhere"), ::testing::ElementsAre("stranger"))
      << "of which nothing was said";
  EXPECT_THAT(Family("nowhere"), ::testing::IsEmpty());
  EXPECT_THAT(Family(""), ::testing::IsEmpty()) << "of no known build is none made";
}

TEST_P(BuildConformance, AFamilyHasABoundAlsoWhereItGoesRound) {
  std::vector<priors::Build> builds = {Build("0", {"19"})};
  for (int i = 1; i < 20; ++i) builds.push_back(Build(std::to_string(i), {std::to_string(i - 1)}));
  ASSERT_TRUE(Describe(builds).ok());
  const auto names = Family("10");
  EXPECT_THAT(names, ::testing::Contains("2"));
  EXPECT_THAT(names, ::testing::Not(::testing::Contains("1"))) << "the ninth before it";
  EXPECT_THAT(Family("0"), ::testing::Contains("19"));
}

TEST_P(BuildConformance, OfALargeFamilyTheAncestorsAreThere) {
  std::vector<priors::Build> builds = {Build("trunk", {"root"}), Build("root", {})};
  for (uint32_t i = 0; i < priors::kMaxFamilyRows; ++i)
    builds.push_back(Build("a" + std::to_string(i), {"other", "trunk"}));
  builds.push_back(Build("zzz", {"trunk"}));
  ASSERT_TRUE(Describe(builds).ok());
  const auto family = *store_->LoadFamily("game", "zzz");
  ASSERT_GE(family.size(), 3u);
  EXPECT_EQ(family[0], Build("root", {}));
  EXPECT_EQ(family[1], Build("trunk", {"root"}));
  EXPECT_EQ(family[2], Build("zzz", {"trunk"}));
  size_t rows = 0;
  for (const priors::Build& one : family) rows += priors::ParentColumn(one).size();
  EXPECT_EQ(rows, priors::kMaxFamilyRows);
}

TEST_P(BuildConformance, AreListedByPagesAndByProject) {
  ASSERT_TRUE(Describe({Build("b", {"a", "z"}), Build("a", {}), Build("c", {"b"}),
                        Build("a", {}, "other game")})
                  .ok());
  std::vector<std::string> names;
  priors::BuildPlace place;
  for (auto page = *store_->ListBuilds({}, place, 1); !page.empty();
       page = *store_->ListBuilds({}, place, 1)) {
    ASSERT_EQ(page.size(), 1u);
    place = {page[0].project, page[0].name};
    names.push_back(place.project + " " + place.name);
  }
  EXPECT_THAT(names, ::testing::ElementsAre("game a", "game b", "game c", "other game a"));
  EXPECT_EQ(store_->ListBuilds({.project = "game", .scene = ""}, {}, 10)->size(), 3u);
  EXPECT_EQ(
      store_->ListBuilds({.project = "", .scene = "", .projects = {"other game"}}, {}, 10)->size(),
      1u);
}

TEST_P(BuildConformance, WhatIsNoBuildChangesNothing) {
  ASSERT_TRUE(Describe({Build("1", {})}).ok());
  const std::vector<priors::Build> wrong[] = {
      {Build("2", {"1"}), Build("", {})},
      {Build("2", {"1"}), Build("3", {"3"})},
      {Build("2", {"1"}), Build("3", {"b", "a"})},
      {Build("2", {"1"}), Build("3", {"a\n"})},
      {Build("2", {"1"}), Build("3", {"1", "2", "3a", "4", "5", "6", "7", "8", "9"})},
      {Build("2", {"1"}), Build("3", {}, "")}};
  for (const auto& builds : wrong) EXPECT_TRUE(absl::IsInvalidArgument(Describe(builds)));
  EXPECT_THAT(*store_->ListBuilds({}, {}, 10), ::testing::ElementsAre(Build("1", {})));
}

TEST_P(BuildConformance, AProjectHasABoundOfThem) {
  std::vector<priors::Build> builds;
  for (uint64_t i = 0; i < priors::kMaxBuilds; ++i) builds.push_back(Build(std::to_string(i), {}));
  ASSERT_TRUE(Describe(builds).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(Describe({Build("one more", {})})));
  EXPECT_TRUE(Describe({Build("0", {"1"})}).ok()) << "is there already";
  EXPECT_TRUE(Describe({Build("0", {}, "other game")}).ok());
  EXPECT_EQ(store_->ListBuilds({.project = "game", .scene = ""}, {}, 20'000)->size(),
            priors::kMaxBuilds);
}

}  // namespace sweepstake::storage
