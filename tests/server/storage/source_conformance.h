// Tests of sources and their revocation for every prior store. Included together with
// prior_store_conformance.h.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "tests/server/storage/prior_store_conformance.h"

namespace sweepstake::storage {

class SourceConformance : public PriorStoreConformance {};

TEST_P(SourceConformance, ARevokedSourceLosesExactlyItsEvidenceAndStaysRevoked) {
  ASSERT_TRUE(
      Commit({Update("a", 1, {Key("Grid"), Key("SAP")}), Update("b", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(store_->Revoke({.id = "a"}, false)->record_count, 2u);
  EXPECT_EQ(Sums({Key("Grid"), Key("SAP")}).source_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{0.75, 0.25, 1, 2}));
  EXPECT_EQ(*store_->LoadSource("a"), std::nullopt);
  ASSERT_TRUE(Commit({Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(store_->Import(std::vector{Record("a", 9, Key("Grid"), 4)})->unchanged_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).source_count, 1u);
  EXPECT_EQ(store_->Revoke({.id = "a"}, false)->record_count, 0u);
  EXPECT_EQ(store_->Revoke({.id = "never seen"}, false)->record_count, 0u);
  ASSERT_TRUE(Commit({Update("never seen", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(Sums({Key("Grid")}).source_count, 1u);
}

// Thirds are rounded in floating point: adding and subtracting one would leave a remainder in the
// sum.
TEST_P(SourceConformance, ARevocationRestoresTheSumsInEveryBit) {
  const auto commit = [&](const std::string& source, double alpha) {
    SourceUpdate update = Update(source, 1, {Key("Grid")});
    update.increments[0].evidence.alpha = alpha;
    ASSERT_TRUE(Commit({update}).ok());
  };
  for (int i = 1; i <= 20; ++i) commit("good " + std::to_string(i), 1.0 / (3 * i));
  const auto before = ExportAll();
  const auto sums = Sums({Key("Grid")}).sums[0].evidence;
  for (int i = 1; i <= 20; ++i) commit("bad " + std::to_string(i), 1e6 / (7 * i));
  for (int i = 1; i <= 20; ++i)
    ASSERT_TRUE(store_->Revoke({.id = "bad " + std::to_string(i)}, false).ok());
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, sums);
  EXPECT_EQ(ExportAll(), before);
}

TEST_P(SourceConformance, ARevocationKeepsSourcesOfOtherProjectsAndTheAdministratorsLog) {
  const std::string admin(decision::kAdminSession);
  ASSERT_TRUE(Commit({UpdateOf({}, 100, "a", {Key("Grid")}), UpdateOf({}, 100, admin, {})}).ok());
  EXPECT_EQ(*store_->Revoke({.id = "a", .project = "other"}, false), priors::ChangeResult{});
  EXPECT_EQ(*store_->Revoke({.id = admin}, false), priors::ChangeResult{});
  EXPECT_EQ(store_->Revoke({.from_unix_s = 1}, true)->source_count, 1u);
  EXPECT_NE(*store_->LoadSource("a"), std::nullopt);
  ASSERT_TRUE(store_->Revoke({.from_unix_s = 1}, false).ok());
  EXPECT_EQ(*store_->LoadSource("a"), std::nullopt);
  EXPECT_NE(*store_->LoadSource(admin), std::nullopt);
}

TEST_P(SourceConformance, ARevocationByBuildOrTimeKeepsOtherKnownSources) {
  ASSERT_TRUE(Commit({UpdateOf({"1.0", 7}, 100, "a", {Key("Grid")})}).ok());
  const priors::SourceFilter none[] = {
      {.id = "a", .build = "1.1"}, {.id = "a", .token_id = 8}, {.id = "a", .until_unix_s = 99}};
  for (const priors::SourceFilter& filter : none)
    EXPECT_EQ(*store_->Revoke(filter, false), priors::ChangeResult{});
  EXPECT_NE(*store_->LoadSource("a"), std::nullopt);
  EXPECT_EQ(store_->Revoke({.id = "a"}, false)->record_count, 1u);
}

TEST_P(SourceConformance, SourcesAreRevokedByBuildTokenAndTimeAndAPreviewChangesNothing) {
  const EvidenceKey elsewhere = [] {
    EvidenceKey key = Key("Grid");
    key.project = "other";
    return key;
  }();
  ASSERT_TRUE(Commit({UpdateOf({"1.0", 7}, 100, "a", {Key("Grid")}),
                      UpdateOf({"1.1", 7}, 200, "b", {Key("Grid"), Key("SAP")}),
                      UpdateOf({"1.1", 8}, 300, "c", {Key("Grid")}),
                      UpdateOf({"1.1", 9}, 300, "d", {elsewhere})})
                  .ok());
  const auto revoked = [&](const priors::SourceFilter& filter) {
    const auto before = ExportAll();
    const auto preview = *store_->Revoke(filter, true);
    EXPECT_EQ(ExportAll(), before);
    EXPECT_EQ(*store_->Revoke(filter, false), preview);
    return preview;
  };
  EXPECT_EQ(revoked({.build = "0.9"}), priors::ChangeResult{});
  EXPECT_EQ(revoked({.token_id = 8}), (priors::ChangeResult{1, 1, 1}));
  EXPECT_EQ(revoked({.from_unix_s = 150, .until_unix_s = 250}), (priors::ChangeResult{1, 2, 2}));
  EXPECT_EQ(Sums({Key("Grid"), Key("SAP")}).source_count, 1u);
  ASSERT_TRUE(Commit({UpdateOf({"1.1", 0}, 400, "e", {Key("Grid")})}).ok());
  EXPECT_EQ(revoked({.project = "game", .build = "1.1"}).record_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{0.75, 0.25, 1, 2}));
  EXPECT_EQ(Sums({elsewhere}).source_count, 1u) << "the evidence of another project stays";
  EXPECT_EQ(revoked({.project = "game", .from_unix_s = 1}), (priors::ChangeResult{1, 1, 1}));
  EXPECT_EQ(ExportAll().size(), 1u);
}

TEST_P(SourceConformance, TheSourcesOfASceneComeFromItsMachineClassAndAFewOthers) {
  EvidenceKey lane = Key("SAP");
  lane.measured_by = "lane";
  EvidenceKey laptop = Key("Grid");
  laptop.machine_class = "laptop";
  EvidenceKey other_reward = Key("Grid");
  other_reward.reward_version = 2;
  ASSERT_TRUE(Commit({UpdateOf({"1.0", 0}, 100, "a", {Key("Grid"), lane}),
                      UpdateOf({"1.1", 0}, 200, "b", {laptop}),
                      UpdateOf({}, 300, "c", {Key("Grid", "desert"), other_reward})})
                  .ok());
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0].id, "a");
  EXPECT_EQ(sources[0].build, "1.0");
  EXPECT_EQ(sources[0].last_seen_unix_s, 100u);
  EXPECT_EQ(sources[0].evidence.key.machine_class, "desktop");
  ASSERT_EQ(sources[0].evidence.arms.size(), 2u);
  EXPECT_EQ(sources[0].evidence.arms[0].live, (priors::Evidence{0.75, 0.25, 1, 2}));
  EXPECT_EQ(sources[0].evidence.arms[1].lane.window_count, 1u);
  EXPECT_EQ(sources[1].id, "b");
  EXPECT_EQ(sources[1].evidence.key.machine_class, "laptop");
  EXPECT_TRUE(store_->LoadSources({"game", "nowhere", "desktop", 1})->empty());
}

TEST_P(SourceConformance, OnlyTheLatestOfManySourcesAreUsedForAScene) {
  for (uint32_t i = 0; i < priors::kSourcesOfScene + 5; ++i) {
    EvidenceKey laptop = Key("Grid");
    laptop.machine_class = "laptop";
    ASSERT_TRUE(Commit({Update("desktop " + std::to_string(i), 1, {Key("Grid")}),
                        Update("laptop " + std::to_string(i), 1, {laptop})})
                    .ok());
  }
  std::map<std::string, std::vector<std::string>> ids;
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  for (const auto& source : sources) ids[source.evidence.key.machine_class].push_back(source.id);
  ASSERT_EQ(ids["desktop"].size(), priors::kSourcesOfScene);
  EXPECT_EQ(ids["desktop"].front(), "desktop 5");
  EXPECT_EQ(ids["laptop"].size(), priors::kSourcesOfOtherClasses);
  EXPECT_EQ(ids["laptop"].back(), "laptop " + std::to_string(priors::kSourcesOfScene + 4));
}

TEST_P(SourceConformance, ATokenWithManySourcesLeavesPlacesForOtherTokens) {
  const auto commit = [&](const std::string& source, int64_t token) {
    ASSERT_TRUE(Commit({UpdateOf({"1.0", token}, 100, source, {Key("Grid")})}).ok());
  };
  for (int i = 0; i < 20; ++i) commit("honest " + std::to_string(i), 1 + i % 2);
  for (int i = 0; i < 200; ++i) commit("flood " + std::to_string(i), 3);
  const auto count_honest = [&] {
    const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
    EXPECT_LE(sources.size(), priors::kSourcesOfScene);
    return std::count_if(sources.begin(), sources.end(),
                         [](const auto& source) { return source.id.starts_with("honest"); });
  };
  EXPECT_EQ(count_honest(), 20);
  for (int i = 20; i < 30; ++i) commit("honest " + std::to_string(i), 1 + i % 2);
  EXPECT_NEAR(count_honest(), 21.5, 0.5) << "of 32 places, shared by three tokens";
  ASSERT_TRUE(store_->Revoke({.token_id = 3}, false).ok());
  EXPECT_EQ(count_honest(), 30);
}

// Without the limit per party the flood would be all of the latest sources.
TEST_P(SourceConformance, APartyWithManySourcesLeavesPlacesForOthersOfItsToken) {
  const auto commit = [&](const std::string& source, const std::string& player,
                          const std::string& network) {
    ASSERT_TRUE(Commit({UpdateOf({"1.0", 7, player, network}, 100, source, {Key("Grid")})}).ok());
  };
  const auto chosen = [&] {
    std::vector<std::string> ids;
    const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
    for (const auto& source : sources) ids.push_back(source.id);
    return ids;
  };
  for (int i = 0; i < 24; ++i)
    commit("honest " + std::to_string(i), "", "203.0." + std::to_string(i) + ".0/24");
  commit("ticket", "alice", "203.0.1.0/24");
  const auto before = chosen();
  EXPECT_EQ(before.size(), 25u);
  for (int i = 0; i < 300; ++i) commit("flood " + std::to_string(i), "", "198.51.100.0/24");
  const auto attacked = chosen();
  EXPECT_EQ(attacked.size(), before.size() + 1) << "free places do not go to one party";
  for (const std::string& id : before)
    EXPECT_NE(std::find(attacked.begin(), attacked.end(), id), attacked.end()) << id;
  EXPECT_NE(std::find(attacked.begin(), attacked.end(), "flood 299"), attacked.end());
  EXPECT_EQ(store_->Revoke({.network = "198.51.100.0/24"}, false)->source_count, 300u);
  EXPECT_EQ(chosen(), before);
  EXPECT_EQ(store_->Revoke({.token_id = 7, .player = "alice"}, false)->source_count, 1u);
  EXPECT_EQ(store_->Revoke({.player = "bob"}, false)->source_count, 0u);
  EXPECT_EQ(chosen().size(), 24u);
}

// If the latest source of a party is revoked, an earlier one takes its place.
TEST_P(SourceConformance, APartyKeepsItsSourcesThatWereNotRevoked) {
  for (const char* id : {"a", "b", "c"}) {
    ASSERT_TRUE(
        Commit({UpdateOf({"1.0", 7, "", "203.0.113.0/24"}, 100, id, {Key("Grid"), Key("SAP")})})
            .ok());
  }
  ASSERT_TRUE(store_->Revoke({.id = "c"}, false).ok());
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[1].id, "b");
  EXPECT_EQ(sources[1].evidence.arms.size(), 2u);
  ASSERT_TRUE(store_->Revoke({.network = "203.0.113.0/24"}, false).ok());
  EXPECT_TRUE(store_->LoadSources({"game", "harbour", "desktop", 1})->empty());
}

// Without the rule the newest classes would be all that a new class begins with.
TEST_P(SourceConformance, MachineClassesThatPlayersAddDoNotDisplaceKnownOnes) {
  const auto key_of = [](const std::string& machine_class) {
    EvidenceKey key = Key("Grid");
    key.machine_class = machine_class;
    return key;
  };
  // One more than for a session whose own class is stored.
  for (uint32_t i = 0; i <= priors::kOtherClasses; ++i) {
    SourceUpdate update =
        UpdateOf({"1.0", 1}, 100, "studio " + std::to_string(i), {key_of("k" + std::to_string(i))});
    update.known = {update.increments[0].key};
    ASSERT_TRUE(Commit({update}).ok());
  }
  for (int i = 0; i < 20; ++i) {
    SourceUpdate update =
        UpdateOf({"1.0", 2, "", "10.0." + std::to_string(i) + ".0/24"}, 100,
                 "player " + std::to_string(i), {key_of("invented " + std::to_string(i))});
    update.is_of_player = true;
    ASSERT_TRUE(Commit({update}).ok());
  }
  const auto sources = *store_->LoadSources({"game", "harbour", "new", 1});
  EXPECT_EQ(sources.size(), priors::kOtherClasses + 1);
  for (const auto& source : sources) EXPECT_TRUE(source.id.starts_with("studio")) << source.id;
}

// Otherwise players could use up the places of a scene's regimes.
TEST_P(SourceConformance, PlayersAddRegimesOnlyWhileTheSceneHasFew) {
  const auto update_of = [&](int number, bool is_of_player) {
    EvidenceKey key = Key("Grid");
    key.regime = std::to_string(number) + "/0/0";
    SourceUpdate update = UpdateOf(
        {"1.0", 7}, 100, (is_of_player ? "player " : "studio ") + std::to_string(number), {key});
    update.is_of_player = is_of_player;
    return update;
  };
  ASSERT_TRUE(Commit({update_of(0, false)}).ok());
  std::vector<SourceUpdate> updates;  // in one transaction, as of simultaneous sessions
  for (int i = 1; i < 10; ++i) updates.push_back(update_of(i, true));
  ASSERT_TRUE(Commit(updates).ok());
  ASSERT_TRUE(Commit({update_of(10, true), update_of(11, false)}).ok());
  EXPECT_EQ(store_->losses().player_increment_count, 7u);
  const auto scene = *store_->LoadScene({"game", "harbour", "desktop", 1});
  ASSERT_TRUE(scene.has_value());
  std::map<std::string, uint64_t> windows;
  for (const auto& [regime, measured] : scene->arms[0].regimes)
    windows[regime] = measured.live.window_count;
  EXPECT_EQ(windows,
            (std::map<std::string, uint64_t>{
                {"", 7}, {"0/0/0", 1}, {"1/0/0", 1}, {"11/0/0", 1}, {"2/0/0", 1}, {"3/0/0", 1}}));
  EXPECT_EQ(scene->arms[0].live.window_count, 12u) << "all of it counts for the scene";
}

// A session of one class also begins with the regimes of others.
TEST_P(SourceConformance, RegimesThatPlayersAddCountOverAllMachineClasses) {
  std::vector<SourceUpdate> updates;
  for (int i = 0; i < 6; ++i) {
    EvidenceKey key = Key("Grid");
    key.machine_class = "class " + std::to_string(i % 3);
    key.regime = std::to_string(i) + "/0/0";
    updates.push_back(UpdateOf({"1.0", 7}, 100, "player " + std::to_string(i), {key}));
    updates.back().is_of_player = true;
  }
  ASSERT_TRUE(Commit(updates).ok());
  EXPECT_EQ(store_->losses().player_increment_count, 2u);
}

// Evidence of a refused class is not stored, so its regimes take no places.
TEST_P(SourceConformance, RegimesOfRefusedMachineClassesDoNotCount) {
  std::vector<SourceUpdate> updates;
  for (int i = 0; i < 12; ++i) {
    EvidenceKey key = Key("Grid");
    key.machine_class = "class " + std::to_string(i);
    if (i >= static_cast<int>(priors::kMaxScenesOfParty)) key.regime = std::to_string(i) + "/0/0";
    updates.push_back(
        UpdateOf({"1.0", 7, "", "10.0.0.0/24"}, 100, "one " + std::to_string(i), {key}));
    updates.back().is_of_player = true;
  }
  EvidenceKey key = Key("Grid");
  key.regime = "99/0/0";
  updates.push_back(UpdateOf({"1.0", 7, "", "10.0.1.0/24"}, 100, "other", {key}));
  updates.back().is_of_player = true;
  ASSERT_TRUE(Commit(updates).ok());
  EXPECT_EQ(
      store_->LoadScene({"game", "harbour", "desktop", 1})->value().arms[0].regimes.count("99/0/0"),
      1u);
  EXPECT_EQ(store_->losses().player_increment_count, 12 - priors::kMaxScenesOfParty);
  EXPECT_EQ(store_->losses().example, "scene harbour of project game, from 10.0.0.0/24");
}

// A client can invent classes and regimes. A limit for each of them would multiply its places.
TEST_P(SourceConformance, OtherMachineClassesHaveOneLimitForAllRegimesTogether) {
  const auto commit = [&](int number, const std::string& machine_class,
                          const std::string& network) {
    EvidenceKey key = Key("Grid");
    key.machine_class = machine_class;
    key.regime = std::to_string(number % 8) + "/0/0";
    ASSERT_TRUE(Commit({UpdateOf({"1.0", 7, "", network}, 100,
                                 machine_class + " " + std::to_string(number), {key})})
                    .ok());
  };
  for (int i = 0; i < 40; ++i) commit(i, "honest", "10.0." + std::to_string(i) + ".0/24");
  for (int i = 0; i < 64; ++i) {
    for (const char* machine_class : {"w", "x", "y", "z"}) commit(i, machine_class, "10.9.9.0/24");
  }
  const auto sources = *store_->LoadSources({"game", "harbour", "new", 1});
  EXPECT_EQ(sources.size(), priors::kSourcesOfOtherClasses);
  EXPECT_GE(std::count_if(sources.begin(), sources.end(),
                          [](const auto& source) { return source.id.starts_with("honest"); }),
            static_cast<int>(priors::kSourcesOfOtherClasses) - 1);
}

// Its keys have ids between those of the other class.
TEST_P(SourceConformance, ASourceOfTwoMachineClassesCountsOnceInEach) {
  std::vector<EvidenceKey> keys;
  for (const char* arm : {"Grid", "SAP", "KDTree"}) {
    for (const char* machine_class : {"desktop", "laptop"}) {
      keys.push_back(Key(arm));
      keys.back().machine_class = machine_class;
    }
  }
  ASSERT_TRUE(Commit({Update("both", 1, keys)}).ok());
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  ASSERT_EQ(sources.size(), 2u);
  for (const auto& source : sources) {
    for (const auto& arm : source.evidence.arms)
      EXPECT_EQ(arm.live, (priors::Evidence{0.75, 0.25, 1, 2})) << arm.name;
  }
}

// 300 players of one token are the latest parties of the scene.
TEST_P(SourceConformance, ManyPartiesOfATokenLeavePlacesForOtherTokens) {
  ASSERT_TRUE(Commit({UpdateOf({"1.0", 1}, 100, "studio", {Key("Grid")})}).ok());
  for (int i = 0; i < 300; ++i) {
    const std::string name = "player-" + std::to_string(i);
    ASSERT_TRUE(Commit({UpdateOf({"1.0", 2, name, ""}, 100, name, {Key("Grid")})}).ok());
  }
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  EXPECT_EQ(sources.size(), priors::kSourcesOfScene);
  EXPECT_EQ(sources.front().id, "studio");
}

TEST_P(SourceConformance, TheOriginOfASourceIsExportedWithItsRecords) {
  ASSERT_TRUE(Commit({UpdateOf({"1.0", 7}, 100, "a", {Key("Grid")})}).ok());
  SourceUpdate later = UpdateOf({"2.0", 8}, 200, "a", {Key("Grid")});
  later.progress.commit_sequence = 2;
  ASSERT_TRUE(Commit({later}).ok());
  std::vector<PriorRecord> records = ExportAll();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].build, "1.0") << "the build of its first update";
  EXPECT_EQ(records[0].last_seen_unix_s, 200u);
  EXPECT_FALSE(records[0].is_imported);
  records[0].source_id = "imported";
  ASSERT_TRUE(store_->Import(records).ok());
  records = ExportAll();
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[1].build, "1.0");
  EXPECT_EQ(records[1].last_seen_unix_s, 200u);
  EXPECT_TRUE(records[1].is_imported);
}

TEST_P(SourceConformance, APreviewSeesTheChangedStoreAndChangesNothing) {
  const SceneKey scene{"game", "harbour", "desktop", 1};
  ASSERT_TRUE(store_->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  PriorRecord waiting = Record("b", 1, Key("SAP"), 1);
  ASSERT_TRUE(store_->Quarantine({&waiting, 1}, 10).ok());
  std::vector<std::string> arms;
  const priors::Preview preview([&](priors::PriorReader& store) {
    arms.clear();
    const auto shown = *store.LoadScene(scene);
    if (!shown) return;
    for (const auto& arm : shown->arms) arms.push_back(arm.name);
  });
  ASSERT_TRUE(store_->Promote({}, preview).ok());
  EXPECT_EQ(arms, (std::vector<std::string>{"Grid", "SAP"}));
  ASSERT_TRUE(store_->Revoke({.id = "a"}, preview).ok());
  EXPECT_TRUE(arms.empty());
  const auto after = *store_->LoadScene(scene);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->arms.size(), 1u);
}

}  // namespace sweepstake::storage
