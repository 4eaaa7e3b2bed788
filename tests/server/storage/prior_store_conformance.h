// Tests for every prior store. prior_store_test.cc and the tests of other backends include it, and
// instantiate PriorStoreConformance with a function that opens a store.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/prior_store.h"
#include "tests/server/storage/evidence_samples.h"

namespace sweepstake::storage {

// The limits of the audit logs of the tested stores.
inline constexpr priors::AuditLimits kConformanceAuditLimits{
    .bytes = 64, .age_s = 3200, .admin_row_count = 5, .steady_ns = FastSteadyNs};

using MakeStore = std::function<std::unique_ptr<PriorStore>()>;

class PriorStoreConformance : public ::testing::TestWithParam<std::pair<std::string, MakeStore>> {
 protected:
  PriorStoreConformance() : store_(GetParam().second()) {}

  absl::Status Commit(const std::vector<SourceUpdate>& updates) { return store_->Commit(updates); }
  KeySums Sums(const std::vector<EvidenceKey>& keys) { return *LoadSums(*store_, keys); }
  std::vector<PriorRecord> ExportAll() { return store_->Export({}, {}, 1000)->records; }

  std::vector<PriorRecord> ExportInPages(uint32_t limit) {
    std::vector<PriorRecord> all;
    priors::ExportPage page;
    do {
      page = *store_->Export({}, page.next, limit);
      all.insert(all.end(), page.records.begin(), page.records.end());
    } while (!page.records.empty());
    return all;
  }

  std::unique_ptr<PriorStore> store_;
};

TEST_P(PriorStoreConformance, AnEmptyStoreHasNoEvidence) {
  const KeySums sums = Sums({Key("Grid"), Key("SAP")});
  ASSERT_EQ(sums.sums.size(), 2u);
  EXPECT_EQ(sums.sums[0].evidence, priors::Evidence{});
  EXPECT_EQ(sums.source_count, 0u);
  EXPECT_EQ(*store_->LoadSource("a"), std::nullopt);
  EXPECT_TRUE(store_->List({}, std::nullopt, 10)->empty());
  EXPECT_TRUE(ExportAll().empty());
}

TEST_P(PriorStoreConformance, EvidenceIsSummedOverSourcesAndKeptApartByKey) {
  EvidenceKey other_version = Key("Grid");
  other_version.backend_version = 2;
  ASSERT_TRUE(
      Commit({Update("a", 1, {Key("Grid")}), Update("b", 1, {Key("Grid"), Key("SAP")})}).ok());
  ASSERT_TRUE(Commit({Update("a", 2, {Key("Grid"), other_version})}).ok());
  const KeySums sums = Sums({Key("Grid"), Key("SAP"), other_version, Key("DBVT")});
  EXPECT_EQ(sums.sums[0].evidence, (priors::Evidence{2.25, 0.75, 3, 6}));
  EXPECT_EQ(sums.sums[0].source_count, 2u);
  EXPECT_EQ(sums.sums[1].evidence, (priors::Evidence{0.75, 0.25, 1, 2}));
  EXPECT_EQ(sums.sums[2].source_count, 1u);
  EXPECT_EQ(sums.sums[3].source_count, 0u);
  EXPECT_EQ(sums.source_count, 2u);
}

TEST_P(PriorStoreConformance, ARepeatedCommitIsIgnored) {
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  ASSERT_TRUE(Commit({Update("a", 3, {Key("Grid")})}).ok());
  ASSERT_TRUE(Commit({Update("a", 2, {Key("Grid")}), Update("a", 3, {Key("Grid")})}).ok());
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.window_count, 2u);
  EXPECT_EQ((*store_->LoadSource("a"))->progress.commit_sequence, 3u);
}

TEST_P(PriorStoreConformance, AnInvalidUpdateUndoesItsWholeCommit) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {-0.5, std::nan(""), infinity, -infinity, 1e15}) {
    SourceUpdate bad = Update("b", 1, {Key("Grid")});
    bad.increments[0].evidence.beta = wrong;
    EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("a", 1, {Key("Grid")}), bad}))) << wrong;
  }
  SourceUpdate nameless = Update("", 1, {});
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({nameless})));
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("a", 0, {})})));
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("a", 1, {Key(std::string(129, 'x'))})})));
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("a", 1, {Key("a\nb")})})));
  EXPECT_EQ(Sums({Key("Grid")}).source_count, 0u);
  EXPECT_EQ(*store_->LoadSource("a"), std::nullopt);
}

TEST_P(PriorStoreConformance, FramesAreCountedWithTheirCommitAndNotByItsReplay) {
  SourceUpdate update = Update("a", 2, {Key("Grid")});
  ASSERT_TRUE(Commit({Update("a", 1, {}), update}).ok());
  EXPECT_EQ((*store_->LoadSource("a"))->progress.frame_count, 2000u);
  update.progress.frame_count = 9999;
  ASSERT_TRUE(Commit({update}).ok());
  SourceUpdate wrong = Update("a", 3, {Key("Grid")});
  wrong.increments[0].evidence.alpha = -1;
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({wrong})));
  wrong = Update("a", 3, {});
  wrong.progress.frame_count = 1ull << 63;
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({wrong})));
  EXPECT_EQ((*store_->LoadSource("a"))->progress.frame_count, 2000u);
}

TEST_P(PriorStoreConformance, KeepsLaneVisitsApartFromWindows) {
  EvidenceKey lane = Key("Grid");
  lane.measured_by = "lane";
  EvidenceKey unseen = Key("BVH");
  unseen.measured_by = "lane";
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid"), lane, unseen}), Update("a", 2, {lane})}).ok());
  const auto scene = *store_->LoadScene({"game", "harbour", "desktop", 1});
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->arms.size(), 2u);
  EXPECT_EQ(scene->arms[0].name, "BVH");
  EXPECT_EQ(scene->arms[0].live, priors::Evidence{});
  EXPECT_EQ(scene->arms[0].lane.window_count, 1u);
  EXPECT_EQ(scene->arms[1].live.window_count, 1u);
  EXPECT_EQ(scene->arms[1].lane.window_count, 2u);
  EXPECT_EQ(Sums({Key("Grid"), lane}).sums[1].evidence.window_count, 2u);
  lane.measured_by = "dice";
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("a", 3, {lane})})));
}

TEST_P(PriorStoreConformance, KeepsTheEvidenceOfEachRegimeApart) {
  EvidenceKey lane = KeyIn("13/-4/0", "Grid");
  lane.measured_by = "lane";
  const EvidenceKey rest = KeyIn("13/-14/3", "Grid"), motion = KeyIn("13/-4/0", "Grid");
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid"), rest, motion, lane}), Update("b", 1, {rest}),
                      Update("a", 2, {motion})})
                  .ok());
  ASSERT_TRUE(Commit({Update("a", 2, {motion})}).ok());  // repeated
  const auto scene = *store_->LoadScene({"game", "harbour", "desktop", 1});
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->arms.size(), 1u);
  EXPECT_EQ(scene->arms[0].live.window_count, 5u);
  EXPECT_EQ(scene->arms[0].lane.window_count, 1u);
  ASSERT_EQ(scene->arms[0].regimes.size(), 3u);
  EXPECT_EQ(scene->arms[0].regimes.at("").live.window_count, 1u);
  EXPECT_EQ(scene->arms[0].regimes.at("13/-14/3").live, (priors::Evidence{1.5, 0.5, 2, 4}));
  EXPECT_EQ(scene->arms[0].regimes.at("13/-4/0").live, (priors::Evidence{1.5, 0.5, 2, 4}));
  EXPECT_EQ(scene->arms[0].regimes.at("13/-4/0").lane.window_count, 1u);
  const auto sources = *store_->LoadSources({"game", "harbour", "desktop", 1});
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0].evidence.arms[0].regimes.size(), 3u);
  EXPECT_EQ(sources[1].evidence.arms[0].regimes.size(), 1u);
  EXPECT_EQ(sources[1].evidence.arms[0].regimes.at("13/-14/3").live.window_count, 1u);
  const auto source = *store_->LoadSource("a");
  ASSERT_EQ(source->evidence.size(), 4u);
  EXPECT_EQ(source->evidence[0].key, Key("Grid"));
  EXPECT_EQ(source->evidence[1].key, rest);
  EXPECT_EQ(source->evidence[2].key, motion);
  EXPECT_EQ(source->evidence[3].key, lane);
}

TEST_P(PriorStoreConformance, ExportsAndImportsTheRegime) {
  const EvidenceKey rest = KeyIn("13/-14/3", "Grid"), motion = KeyIn("13/-4/0", "Grid");
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid"), rest, motion})}).ok());
  ASSERT_TRUE(store_->Import(std::vector{Record("b", 1, motion, 2), Record("b", 1, rest, 3)}).ok());
  const std::vector<PriorRecord> records = ExportInPages(1);
  ASSERT_EQ(records.size(), 5u);
  EXPECT_TRUE(std::is_sorted(records.begin(), records.end(),
                             [](const auto& x, const auto& y) { return x.key < y.key; }));
  EXPECT_EQ(std::count_if(records.begin(), records.end(),
                          [&](const PriorRecord& record) { return record.key == motion; }),
            2);
  ASSERT_TRUE(store_->Revoke({.id = "a"}, /*preview=*/false).ok());
  const auto scene = *store_->LoadScene({"game", "harbour", "desktop", 1});
  EXPECT_EQ(scene->arms[0].regimes.size(), 2u);
  EXPECT_EQ(scene->arms[0].regimes.at("13/-14/3").live.alpha, 3);
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("c", 1, {KeyIn("fast", "Grid")})})));
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({Update("c", 1, {KeyIn("-/-/-", "Grid")})})));
}

TEST_P(PriorStoreConformance, CountsSaturateAtTheirLimit) {
  PriorRecord record = Record("a", 1, Key("Grid"), 1);
  record.evidence.window_count = record.evidence.bail_out_count = (1ull << 63) - 1;
  std::vector<PriorRecord> records(3, record);
  for (size_t i = 0; i < records.size(); ++i) records[i].source_id = std::to_string(i);
  ASSERT_TRUE(store_->Import(records).ok());
  const auto scenes = store_->List({}, std::nullopt, 10);
  ASSERT_TRUE(scenes.ok()) << scenes.status();
  EXPECT_EQ(scenes->at(0).arms[0].live.window_count, record.evidence.window_count);
  EXPECT_EQ(scenes->at(0).arms[0].live.bail_out_count, record.evidence.bail_out_count);
}

TEST_P(PriorStoreConformance, ASourceIsLoadedWithItsProgressAndItsOwnEvidence) {
  ASSERT_TRUE(Commit({Update("a", 1, {Key("SAP")}), Update("b", 1, {Key("Grid")})}).ok());
  const SourceUpdate last = Update("a", 2, {Key("SAP"), Key("Grid")});
  ASSERT_TRUE(Commit({last}).ok());
  const auto source = *store_->LoadSource("a");
  ASSERT_TRUE(source.has_value());
  EXPECT_EQ(source->progress, last.progress);
  EXPECT_THAT(source->evidence,
              ::testing::ElementsAre(priors::KeyedEvidence{Key("Grid"), {0.75, 0.25, 1, 2}},
                                     priors::KeyedEvidence{Key("SAP"), {1.5, 0.5, 2, 4}}));
}

TEST_P(PriorStoreConformance, ProgressWithoutEvidenceIsKept) {
  ASSERT_TRUE(Commit({Update("a", 1, {})}).ok());
  ASSERT_TRUE((*store_->LoadSource("a")).has_value());
  EXPECT_EQ((*store_->LoadSource("a"))->progress.message_sequence, 10u);
  EXPECT_TRUE(store_->List({}, std::nullopt, 10)->empty());
}

TEST_P(PriorStoreConformance, ASourceHasTheTimesOfItsFirstAndLastCommit) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 1, Key("Grid"), 1)}).ok());
  for (const uint64_t n : {1u, 2u, 2u, 3u}) {
    SourceUpdate update = Update("a", n, {});
    update.unix_time_s = 1'800'000'000 + n;
    ASSERT_TRUE(Commit({update}).ok());
  }
  EXPECT_EQ((*store_->LoadSource("a"))->created_unix_s, 1'800'000'001u);
  EXPECT_EQ((*store_->LoadSource("a"))->last_seen_unix_s, 1'800'000'003u);
  SourceUpdate wrong = Update("a", 4, {});
  wrong.unix_time_s = 1ull << 63;
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({wrong})));
}

TEST_P(PriorStoreConformance, AnArmHasTheTimeOfItsLatestSource) {
  EvidenceKey lane = Key("SAP");
  lane.measured_by = "lane";
  PriorRecord timeless = Record("i", 1, Key("DBVT"), 1);
  ASSERT_TRUE(store_->Import({&timeless, 1}).ok());
  ASSERT_TRUE(Commit({UpdateOf({}, 300, "a", {Key("Grid"), Key("SAP")}),
                      UpdateOf({}, 200, "b", {Key("Grid"), lane})})
                  .ok());
  SourceUpdate later = Update("b", 2, {});
  later.unix_time_s = 400;
  ASSERT_TRUE(Commit({later}).ok());
  const auto seen = [&] {
    std::map<std::string, uint64_t> times;
    const auto scene = *store_->LoadScene({"game", "harbour", "desktop", 1});
    for (const auto& arm : scene->arms) times[arm.name] = arm.last_seen_unix_s;
    const auto listed = *store_->List({}, std::nullopt, 1);
    EXPECT_EQ(listed.at(0).arms.at(1).last_seen_unix_s, times["Grid"]);
    return times;
  };
  using Times = std::map<std::string, uint64_t>;
  EXPECT_EQ(seen(), (Times{{"DBVT", 0}, {"Grid", 400}, {"SAP", 400}}));
  ASSERT_TRUE(store_->Revoke({.id = "b"}, false).ok());
  EXPECT_EQ(seen(), (Times{{"DBVT", 0}, {"Grid", 300}, {"SAP", 300}}));
  for (uint32_t i = 0; i < priors::kSourcesOfAge; ++i)
    ASSERT_TRUE(Commit({UpdateOf({}, 10 + i, std::to_string(i), {Key("Grid")})}).ok());
  EXPECT_EQ(seen()["Grid"], 9 + priors::kSourcesOfAge) << "only the latest sources are looked up";
}

TEST_P(PriorStoreConformance, ScenesAreListedInPagesAndByFilter) {
  for (const char* scene : {"c", "a", "d", "b"}) {
    ASSERT_TRUE(
        Commit({Update(std::string("source ") + scene, 1, {Key("SAP", scene), Key("Grid", scene)})})
            .ok());
  }
  const auto first = *store_->List({}, std::nullopt, 3);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].key.scene, "a");
  EXPECT_EQ(first[2].key.scene, "c");
  EXPECT_EQ(first[0].source_count, 1u);
  ASSERT_EQ(first[0].arms.size(), 2u);
  EXPECT_EQ(first[0].arms[0].name, "Grid");
  const auto second = *store_->List({}, first[2].key, 3);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].key.scene, "d");
  EXPECT_EQ(store_->List({"game", "b"}, std::nullopt, 3)->size(), 1u);
  EXPECT_TRUE(store_->List({"other game", ""}, std::nullopt, 3)->empty());
}

TEST_P(PriorStoreConformance, SeveralProjectsAreListedExportedAndTheirScenesCounted) {
  std::vector<EvidenceKey> keys;
  for (const char* project : {"a", "b", "b c", "c"}) {
    for (const char* scene : {"harbour", "hall"}) {
      keys.push_back(Key("Grid", scene));
      keys.back().project = project;
    }
  }
  keys.push_back(keys.back());
  keys.back().machine_class = "laptop";
  ASSERT_TRUE(Commit({Update("s", 1, keys)}).ok());
  const priors::SceneFilter filter{"", "hall", {"b", "c", "none"}};
  std::vector<std::string> listed, exported;
  const auto scenes = store_->List(filter, std::nullopt, 10);
  for (const auto& scene : *scenes)
    listed.push_back(scene.key.project + "/" + scene.key.machine_class);
  const auto records = store_->Export(filter, {}, 10)->records;
  for (const auto& record : records)
    exported.push_back(record.key.project + "/" + record.key.machine_class);
  EXPECT_THAT(listed, ::testing::ElementsAre("b/desktop", "c/desktop", "c/laptop"));
  EXPECT_EQ(exported, listed);
  EXPECT_TRUE(store_->List({"a", "", {"b"}}, std::nullopt, 10)->empty());
  EXPECT_EQ(store_->CountScenes("c")->names, 2u);
  EXPECT_EQ(store_->CountScenes("c")->keys, 3u);
  EXPECT_EQ(store_->CountScenes("none")->names, 0u);
  EXPECT_EQ(*store_->CountProjects(), 4u);
}

TEST_P(PriorStoreConformance, AnUnknownSceneIsAbsent) {
  EXPECT_EQ(store_->LoadScene({"game", "nowhere", "desktop", 1})->has_value(), false);
}

TEST_P(PriorStoreConformance, NamesAreTreatedAsTextAndNotAsSql) {
  const std::string scene = "'; DROP TABLE evidence; -- \xc3\xa9\xe2\x82\xac";
  ASSERT_TRUE(Commit({Update("a", 1, {Key("<script>", scene)})}).ok());
  const auto loaded = *store_->LoadScene({"game", scene, "desktop", 1});
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(loaded->arms[0].name, "<script>");
}

TEST_P(PriorStoreConformance, RecordsAreExportedInPagesAndByFilter) {
  ASSERT_TRUE(Commit({Update("b", 1, {Key("Grid"), Key("SAP")}),
                      Update("a", 1, {Key("Grid", "abbey"), Key("Grid")})})
                  .ok());
  const auto all = ExportAll();
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].key, Key("Grid", "abbey"));
  EXPECT_EQ(all[1].source_id, "b") << "its source was stored first";
  EXPECT_EQ(all[2].source_id, "a");
  EXPECT_EQ(all[2].source_sequence, 1u);
  for (const uint32_t limit : {1u, 2u, 3u}) EXPECT_EQ(ExportInPages(limit), all) << limit;
  EXPECT_EQ(store_->Export({"game", "abbey"}, {}, 10)->records.size(), 1u);
  EXPECT_EQ(store_->Export({"game", "harbour"}, {}, 10)->records.size(), 3u);
  EXPECT_TRUE(store_->Export({"other game", ""}, {}, 10)->records.empty());
}

TEST_P(PriorStoreConformance, AnExportContinuesAtItsPlaceWhileSourcesChange) {
  for (const char* source : {"a", "b", "c"})
    ASSERT_TRUE(Commit({Update(source, 1, {Key("Grid"), Key("SAP")})}).ok());
  const auto page = *store_->Export({}, {}, 2);
  EXPECT_EQ(page.records[1].source_id, "b");
  ASSERT_TRUE(store_->Revoke({.id = "b"}, false).ok());
  ASSERT_TRUE(Commit({Update("a", 2, {Key("Grid")}), Update("d", 1, {Key("Grid")})}).ok());
  std::vector<std::string> rest;
  const auto behind = *store_->Export({}, page.next, 10);
  for (const PriorRecord& record : behind.records) rest.push_back(record.source_id);
  EXPECT_EQ(rest, (std::vector<std::string>{"c", "d", "a", "c"}));
}

TEST_P(PriorStoreConformance, ExportedRecordsCanBeImportedElsewhereOnce) {
  ASSERT_TRUE(
      Commit({Update("a", 1, {Key("Grid")}), Update("b", 4, {Key("Grid"), Key("SAP")})}).ok());
  const std::unique_ptr<PriorStore> other = GetParam().second();
  const auto first = other->Import(ExportAll());
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first->applied_count, 3u);
  const auto second = other->Import(ExportAll());
  EXPECT_EQ(second->applied_count, 0u);
  EXPECT_EQ(second->unchanged_count, 3u);
  std::vector<PriorRecord> imported = ExportAll();
  for (PriorRecord& record : imported) record.is_imported = true;
  EXPECT_EQ(other->Export({}, {}, 10)->records, imported);
}

TEST_P(PriorStoreConformance, AnImportReplacesOlderRecordsAndIgnoresOlderOnes) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 5, Key("Grid"), 4)}).ok());
  EXPECT_EQ(store_->Import(std::vector{Record("a", 4, Key("Grid"), 100)})->unchanged_count, 1u);
  EXPECT_EQ(store_->Import(std::vector{Record("a", 6, Key("Grid"), 7)})->applied_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{7, 0.5, 3, 0}));
}

TEST_P(PriorStoreConformance, AnInvalidRecordUndoesItsWholeImport) {
  PriorRecord bad = Record("b", 1, Key("Grid"), std::nan(""));
  const auto result = store_->Import(std::vector{Record("a", 1, Key("Grid"), 1), bad});
  ASSERT_TRUE(absl::IsInvalidArgument(result.status()));
  EXPECT_THAT(std::string(result.status().message()), ::testing::HasSubstr("record 1"));
  EXPECT_TRUE(ExportAll().empty());
}

TEST_P(PriorStoreConformance, AStoppedChangeFailsAndChangesNothing) {
  const std::vector fresh{Record("c", 1, Key("Grid"), 1.0)};
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 1, Key("Grid"), 1.0)}).ok());
  ASSERT_TRUE(store_->Quarantine(std::vector{Record("b", 1, Key("Grid"), 1.0)}, 10).ok());
  std::atomic<bool> stop = true;
  store_->StopChangesWhen(stop);
  EXPECT_TRUE(absl::IsCancelled(store_->Import(fresh).status()));
  EXPECT_TRUE(absl::IsCancelled(store_->Quarantine(fresh, 10).status()));
  EXPECT_TRUE(absl::IsCancelled(store_->Promote({.id = "b"}, false).status()));
  EXPECT_TRUE(absl::IsCancelled(store_->Revoke({.id = "a"}, false).status()));
  EXPECT_EQ(ExportAll().size(), 1u);
  EXPECT_EQ(store_->ExportQuarantined({}, {}, 10)->records.size(), 1u);
  EXPECT_TRUE(Commit({Update("d", 1, {Key("Grid")})}).ok()) << "commits continue";
  stop = false;
  EXPECT_EQ(store_->Import(fresh)->applied_count, 1u);
  EXPECT_EQ(ExportAll().size(), 3u);
  store_.reset();
}

TEST_P(PriorStoreConformance, ACommitThatOverflowsASourceIsRefusedAndChangesNothing) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 1, Key("Grid"), 9e14)}).ok());
  const auto before = ExportAll();
  SourceUpdate update = Update("a", 1, {Key("Grid")});
  update.increments[0].evidence.alpha = 9e14;
  EXPECT_TRUE(absl::IsInvalidArgument(Commit({update})));
  EXPECT_EQ(ExportAll(), before);
  update.increments[0].evidence.alpha = 9e13;
  EXPECT_TRUE(Commit({update}).ok());
}

TEST_P(PriorStoreConformance, AnImportedSourceCannotBeResumed) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 5, Key("Grid"), 4)}).ok());
  EXPECT_EQ(*store_->LoadSource("a"), std::nullopt);
}

TEST_P(PriorStoreConformance, AnImportDoesNotChangeSessionsOfTheStore) {
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  const auto before = *store_->LoadSource("a");
  const auto result =
      store_->Import(std::vector{Record("a", 50, Key("Grid"), 4), Record("a", 50, Key("SAP"), 4)});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->applied_count, 0u);
  EXPECT_EQ(result->unchanged_count, 2u);
  EXPECT_EQ((*store_->LoadSource("a"))->progress, before->progress);
  EXPECT_EQ((*store_->LoadSource("a"))->evidence, before->evidence);
  ASSERT_TRUE(Commit({Update("a", 2, {Key("Grid")})}).ok());
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.window_count, 2u);
}

TEST_P(PriorStoreConformance, ACommitOfASourceThatWasImportedBeforeCounts) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 50, Key("Grid"), 4)}).ok());
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{4.75, 0.75, 4, 2}));
}

// Sums the exported records independently, like a store without stored sums.
inline void ExpectSumsOf(PriorStore& store, const std::vector<PriorRecord>& records) {
  std::map<SceneKey, std::set<std::string>> sources;
  std::map<EvidenceKey, KeySum> sums;
  for (const PriorRecord& record : records) {
    const EvidenceKey& key = record.key;
    sources[{key.project, key.scene, key.machine_class, key.reward_version}].insert(
        record.source_id);
    sums[key].evidence += record.evidence;
    ++sums[key].source_count;
  }
  for (const auto& [key, sum] : sums) {
    const KeySum kept = LoadSums(store, {key})->sums[0];
    EXPECT_EQ(kept.evidence, sum.evidence) << "exactly";
    EXPECT_EQ(kept.source_count, sum.source_count);
  }
  const auto scenes = *store.List({}, std::nullopt, 1000);
  EXPECT_EQ(scenes.size(), sources.size());
  for (const auto& scene : scenes) EXPECT_EQ(scene.source_count, sources[scene.key].size());
}

TEST_P(PriorStoreConformance, SumsEqualTheSumsOfTheRecordsAfterAnyHistory) {
  std::mt19937_64 random(20'260'101);
  const auto pick = [&](uint64_t count) { return random() % count; };
  const auto any_key = [&] {
    return Key("arm " + std::to_string(pick(3)), "scene " + std::to_string(pick(3)));
  };
  for (uint64_t step = 1; step <= 300; ++step) {
    const std::string source = std::to_string(pick(12) + step / 25);
    const EvidenceKey key = any_key();
    const auto amount = static_cast<double>(pick(1'000'000)) * 1e-7;
    if (const uint64_t what = pick(20); what == 0) {
      ASSERT_TRUE(store_->Revoke({.id = source}, false).ok());
    } else if (what < 5) {
      const PriorRecord record = Record("import " + source, pick(step) + 1, key, 1e6 * amount);
      ASSERT_TRUE(store_->Import({&record, 1}).ok());
    } else {
      SourceUpdate update = Update(source, step, {key});
      update.increments[0].evidence.alpha = amount;
      ASSERT_TRUE(Commit({update}).ok());
    }
    if (step % 20 == 0) ExpectSumsOf(*store_, ExportAll());
  }
}

}  // namespace sweepstake::storage
