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
};

TEST_P(BuildConformance, OfABuildItHasWhatWasSaidLast) {
  ASSERT_TRUE(Describe({Build("2", {"1", "1-fix"})}).ok());
  priors::Build again = Build("2", {"1"});
  again.unix_made_s = 1'760'000'000;
  ASSERT_TRUE(Describe({again, Build("1", {})}).ok());
  EXPECT_THAT(*store_->ListBuilds({}, {}, 10), ::testing::ElementsAre(Build("1", {}), again));
}

TEST_P(BuildConformance, ItHasThoseThatAreAskedFor) {
  const priors::Build merged = Build("3", {"1", "fix"});
  ASSERT_TRUE(
      Describe({Build("1", {}), Build("2", {"1"}), merged, Build("3", {"2"}, "other game")}).ok());
  const auto load = [&](const std::vector<std::string>& names) {
    return *store_->LoadBuilds("game", names);
  };
  EXPECT_THAT(load({"3", "1", "nowhere", "fix"}),
              ::testing::UnorderedElementsAre(merged, Build("1", {})));
  EXPECT_THAT(load({"nowhere", ""}), ::testing::IsEmpty());
  EXPECT_THAT(load({}), ::testing::IsEmpty());
}

TEST_P(BuildConformance, WhatIsForgottenIsAsIfNothingHadBeenSaid) {
  ASSERT_TRUE(
      Describe({Build("1.O", {"1"}), Build("2", {"1.O"}), Build("1.O", {}, "other game")}).ok());
  const std::vector<priors::BuildPlace> forgotten = {{"game", "1.O"}, {"game", "nowhere"}};
  ASSERT_TRUE(store_->ForgetBuilds(forgotten).ok());
  EXPECT_THAT(*store_->ListBuilds({}, {}, 10),
              ::testing::ElementsAre(Build("2", {"1.O"}), Build("1.O", {}, "other game")));
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
  priors::Build too_late = Build("3", {});
  too_late.unix_made_s = uint64_t{priors::kMaxUnixMadeS} + 1;
  const std::vector<priors::Build> wrong[] = {
      {Build("2", {"1"}), Build("", {})},
      {Build("2", {"1"}), Build("3", {"3"})},
      {Build("2", {"1"}), Build("3", {"b", "a"})},
      {Build("2", {"1"}), Build("3", {"a\n"})},
      {Build("2", {"1"}), Build("3", {"1", "2", "3a", "4", "5", "6", "7", "8", "9"})},
      {Build("2", {"1"}), Build("3", {}, "")},
      {Build("2", {"1"}), too_late}};
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
