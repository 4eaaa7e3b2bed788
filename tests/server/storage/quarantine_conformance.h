// Tests of imports in quarantine for every prior store. Included together with
// prior_store_conformance.h.
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/storage/prior_store_conformance.h"

namespace sweepstake::storage {

class QuarantineConformance : public PriorStoreConformance {
 protected:
  static constexpr uint64_t kAnyNumber = 1'000'000;

  // The data that sessions, watchers and exports read from a store, compared bit by bit.
  struct Seen {
    std::vector<PriorRecord> exported;
    std::vector<std::pair<SceneKey, std::vector<priors::Evidence>>> scenes;
    std::vector<std::string> sources;

    friend bool operator==(const Seen&, const Seen&) = default;
  };
  static Seen Look(PriorStore& store) {
    Seen seen{.exported = store.Export({}, {}, 1000)->records, .scenes = {}, .sources = {}};
    const auto scenes = *store.List({}, std::nullopt, 1000);
    for (const auto& scene : scenes) {
      auto& [key, sums] = seen.scenes.emplace_back();
      key = scene.key;
      for (const auto& arm : scene.arms) sums.insert(sums.end(), {arm.live, arm.lane});
      const auto sources = *store.LoadSources(key);
      for (const auto& source : sources) seen.sources.push_back(key.scene + " " + source.id);
    }
    return seen;
  }
  Seen Look() { return Look(*store_); }
  priors::ImportResult Quarantine(const std::vector<PriorRecord>& records) {
    const auto result = store_->Quarantine(records, kAnyNumber);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.value_or(priors::ImportResult{});
  }
  std::vector<PriorRecord> Waiting() { return store_->ExportQuarantined({}, {}, 1000)->records; }
};

TEST_P(QuarantineConformance, AQuarantinedImportIsVisibleOnlyInTheQuarantine) {
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  const Seen before = Look();
  PriorRecord record = Record("i", 5, Key("Grid"), 4);
  record.build = "0.9";
  EXPECT_EQ(Quarantine({record, Record("i", 5, Key("SAP", "canyon"), 1)}).applied_count, 2u);
  EXPECT_EQ(Look(), before);
  EXPECT_EQ(store_->LoadScene({"game", "canyon", "desktop", 1})->has_value(), false);
  EXPECT_EQ(store_->CountScenes("game")->keys, 1u);
  EXPECT_EQ(*store_->LoadSource("i"), std::nullopt);
  record.is_imported = record.is_quarantined = true;
  ASSERT_EQ(Waiting().size(), 2u);
  EXPECT_EQ(Waiting()[1], record);
}

TEST_P(QuarantineConformance, PromotingGivesExactlyTheResultOfAnImport) {
  const std::unique_ptr<PriorStore> other = GetParam().second();
  std::mt19937_64 random(20'260'324);
  std::vector<PriorRecord> records;
  for (int i = 0; i < 60; ++i) {
    records.push_back(Record("i" + std::to_string(random() % 7), 1 + random() % 3,
                             Key(i % 2 == 0 ? "Grid" : "SAP", "scene " + std::to_string(i % 5)),
                             1e6 / (3.0 + static_cast<double>(random() % 1000))));
  }
  for (PriorStore* store : {store_.get(), other.get()})
    ASSERT_TRUE(store->Commit(std::vector{Update("a", 1, {Key("Grid", "scene 0")})}).ok());
  const Seen before = Look();
  ASSERT_TRUE(other->Import(records).ok());
  Quarantine(records);
  EXPECT_EQ(Look(), before);
  const auto promoted = *store_->Promote({}, false);
  EXPECT_EQ(promoted.source_count, 7u);
  EXPECT_EQ(promoted.scene_count, 5u);
  EXPECT_EQ(Look(), Look(*other));
  EXPECT_TRUE(Waiting().empty());
  for (int i = 0; i < 7; ++i)
    ASSERT_TRUE(store_->Revoke({.id = "i" + std::to_string(i)}, false).ok());
  EXPECT_EQ(Look(), before) << "equal in every bit";
}

TEST_P(QuarantineConformance, SourcesArePromotedByIdBuildAndProjectAndAPreviewChangesNothing) {
  EvidenceKey elsewhere = Key("Grid");
  elsewhere.project = "other";
  PriorRecord of_build = Record("b", 1, Key("Grid"), 2);
  of_build.build = "0.9";
  Quarantine({Record("a", 1, Key("Grid"), 1), Record("a", 1, Key("SAP"), 1),
              Record("a", 1, elsewhere, 1), of_build});
  const auto promoted = [&](const priors::SourceFilter& filter) {
    const auto waiting = Waiting();
    const Seen before = Look();
    const auto preview = *store_->Promote(filter, true);
    EXPECT_EQ(Waiting(), waiting);
    EXPECT_EQ(Look(), before);
    EXPECT_EQ(*store_->Promote(filter, false), preview);
    EXPECT_EQ(*store_->Promote(filter, false), priors::ChangeResult{}) << "once";
    return preview;
  };
  EXPECT_EQ(promoted({.id = "nobody"}), priors::ChangeResult{});
  EXPECT_EQ(promoted({.token_id = 7}), priors::ChangeResult{}) << "imported sources have no token";
  EXPECT_EQ(promoted({.build = "0.9"}), (priors::ChangeResult{1, 1, 3, 1}));
  EXPECT_EQ(promoted({.id = "a", .project = "game"}), (priors::ChangeResult{1, 2, 6, 1}));
  EXPECT_EQ(Sums({Key("Grid"), Key("SAP")}).source_count, 2u);
  EXPECT_EQ(Waiting().size(), 1u);
  EXPECT_EQ(promoted({.project = "other", .until_unix_s = 5}), (priors::ChangeResult{1, 1, 3, 1}));
  EXPECT_TRUE(Waiting().empty());
}

TEST_P(QuarantineConformance, ANewerWaitingRecordReplacesTheCountingOneWhenPromoted) {
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 5, Key("Grid"), 4)}).ok());
  EXPECT_EQ(Quarantine({Record("a", 5, Key("Grid"), 100)}).unchanged_count, 1u);
  EXPECT_EQ(Quarantine({Record("a", 6, Key("Grid"), 7)}).applied_count, 1u);
  EXPECT_EQ(Quarantine({Record("a", 6, Key("Grid"), 7)}).unchanged_count, 1u) << "twice";
  EXPECT_EQ(Quarantine({Record("a", 7, Key("Grid"), 8)}).applied_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.alpha, 4.0);
  EXPECT_EQ(*store_->Promote({}, false), (priors::ChangeResult{1, 1, 3, 1}));
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{8, 0.5, 3, 0}));
  EXPECT_EQ(Sums({Key("Grid")}).source_count, 1u);
}

TEST_P(QuarantineConformance, AnImportWithoutQuarantineDropsOlderWaitingRecords) {
  Quarantine({Record("a", 5, Key("Grid"), 4), Record("b", 9, Key("Grid"), 1)});
  const auto imported =
      store_->Import(std::vector{Record("a", 5, Key("Grid"), 4), Record("b", 8, Key("Grid"), 2)});
  EXPECT_EQ(imported->applied_count, 2u);
  ASSERT_EQ(Waiting().size(), 1u);
  EXPECT_EQ(Waiting()[0].source_id, "b") << "the waiting record is newer";
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence.alpha, 6.0);
}

TEST_P(QuarantineConformance, ARevokedSourceLosesItsWaitingRecordsAndStaysRevoked) {
  ASSERT_TRUE(Commit({Update("s", 1, {Key("Grid")})}).ok());
  const Seen before = Look();
  ASSERT_TRUE(store_->Import(std::vector{Record("a", 1, Key("Grid"), 1)}).ok());
  Quarantine({Record("a", 2, Key("Grid"), 2), Record("b", 1, Key("Grid"), 4)});
  const auto preview = *store_->Revoke({.id = "a"}, true);
  EXPECT_EQ(preview, (priors::ChangeResult{1, 2, 6})) << "one counting and one waiting record";
  EXPECT_EQ(Waiting().size(), 2u);
  EXPECT_EQ(*store_->Revoke({.id = "a"}, false), preview);
  EXPECT_EQ(Look(), before);
  EXPECT_EQ(store_->Revoke({.id = "b", .project = "other"}, false)->source_count, 0u);
  EXPECT_EQ(*store_->Revoke({.id = "b", .project = "game"}, false),
            (priors::ChangeResult{1, 1, 3}));
  EXPECT_TRUE(Waiting().empty());
  EXPECT_EQ(Quarantine({Record("a", 9, Key("Grid"), 1)}).unchanged_count, 1u);
  EXPECT_EQ(*store_->Promote({}, false), priors::ChangeResult{});
  EXPECT_EQ(Look(), before);
}

TEST_P(QuarantineConformance, RecordsOfOtherProjectsCanBePromotedAfterARevocation) {
  EvidenceKey elsewhere = Key("Grid");
  elsewhere.project = "other";
  Quarantine({Record("a", 1, Key("Grid"), 1), Record("a", 1, elsewhere, 2)});
  EXPECT_EQ(store_->Revoke({.id = "a", .project = "game"}, false)->record_count, 1u);
  ASSERT_EQ(Waiting().size(), 1u);
  EXPECT_EQ(store_->Promote({}, false)->record_count, 1u);
  EXPECT_TRUE(Waiting().empty());
  EXPECT_EQ(Sums({elsewhere}).sums[0].evidence.alpha, 2.0);
}

TEST_P(QuarantineConformance, ASourceThatCommitsHereLosesItsWaitingRecords) {
  Quarantine({Record("a", 50, Key("Grid"), 4), Record("b", 50, Key("Grid"), 4)});
  ASSERT_TRUE(Commit({Update("a", 1, {Key("Grid")})}).ok());
  ASSERT_EQ(Waiting().size(), 1u);
  EXPECT_EQ(Waiting()[0].source_id, "b");
  EXPECT_EQ(Quarantine({Record("a", 51, Key("Grid"), 4)}).unchanged_count, 1u);
  EXPECT_EQ(Sums({Key("Grid")}).sums[0].evidence, (priors::Evidence{0.75, 0.25, 1, 2}));
}

TEST_P(QuarantineConformance, AnImportAboveTheQuarantineLimitIsRefusedCompletely) {
  const auto full = [&](const std::vector<PriorRecord>& records) {
    return absl::IsResourceExhausted(store_->Quarantine(records, 2).status());
  };
  EXPECT_FALSE(full({Record("a", 1, Key("Grid"), 1), Record("b", 1, Key("Grid"), 1)}));
  EXPECT_FALSE(full({Record("b", 2, Key("Grid"), 1)})) << "this replaces an older record";
  EXPECT_TRUE(full({Record("b", 3, Key("Grid"), 1), Record("c", 1, Key("Grid"), 1)}));
  ASSERT_EQ(Waiting().size(), 2u);
  EXPECT_EQ(Waiting()[1].source_sequence, 2u);
  EXPECT_TRUE(absl::IsInvalidArgument(
      store_->Quarantine(std::vector{Record("d", 1, Key("Grid"), -1)}, 9).status()));
  EXPECT_EQ(Waiting().size(), 2u);
}

TEST_P(QuarantineConformance, TheQuarantineIsExportedInPagesAndByFilter) {
  std::vector<PriorRecord> records;
  for (const char* scene : {"harbour", "abbey"}) {
    for (const char* source : {"b", "a"}) {
      records.push_back(Record(source, 1, Key("Grid", scene), 1));
      records.push_back(Record(source, 1, Key("SAP", scene), 1));
    }
  }
  Quarantine(records);
  const auto all = Waiting();
  ASSERT_EQ(all.size(), 8u);
  EXPECT_EQ(all[0].key, Key("Grid", "abbey"));
  EXPECT_EQ(all[0].source_id, "b") << "its source was stored first";
  for (const uint32_t limit : {1u, 3u}) {
    std::vector<PriorRecord> in_pages;
    for (auto page = *store_->ExportQuarantined({}, {}, limit); !page.records.empty();
         page = *store_->ExportQuarantined({}, page.next, limit))
      in_pages.insert(in_pages.end(), page.records.begin(), page.records.end());
    EXPECT_EQ(in_pages, all) << limit;
  }
  EXPECT_EQ(store_->ExportQuarantined({"game", "abbey"}, {}, 99)->records.size(), 4u);
  EXPECT_TRUE(store_->ExportQuarantined({"other", ""}, {}, 99)->records.empty());
  EXPECT_TRUE(store_->ExportQuarantined({"", "", {"other"}}, {}, 99)->records.empty());
}

}  // namespace sweepstake::storage
