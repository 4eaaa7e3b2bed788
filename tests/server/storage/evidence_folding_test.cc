// Old evidence that is folded together: nothing is lost or counted twice.
#include "server/storage/folding/evidence_folding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <future>
#include <map>
#include <random>
#include <set>

#include "server/storage/backup/sqlite_backup.h"
#include "server/storage/memory/memory_prior_store.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/store_thread.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr uint64_t kDayS = 86'400;
constexpr uint64_t kNowS = 1'800'000'000;  // in January 2027

SourceUpdate At(uint64_t unix_time_s, SourceUpdate update) {
  update.unix_time_s = unix_time_s;
  return update;
}

FoldStep FoldAll(PriorStore& store, uint64_t last_unix_s, const FoldPlace& after = {}) {
  FoldStep all{.next = after};
  do {
    const auto step = FoldSources(store, all.next, last_unix_s);
    EXPECT_TRUE(step.ok()) << step.status();
    if (!step.ok()) break;
    all.next = step->next;
    all.source_count += step->source_count;
    all.record_count += step->record_count;
    all.last = step->last;
  } while (!all.last);
  return all;
}

// What an export has, page by page.
priors::ExportPage ExportPages(PriorStore& store, uint32_t limit) {
  priors::ExportPage all;
  for (bool more = true; more;) {
    const auto page = store.Export({}, all.next, limit);
    EXPECT_TRUE(page.ok()) << page.status();
    all.records.insert(all.records.end(), page->records.begin(), page->records.end());
    all.folded_record_count += page->folded_record_count;
    all.folded_window_count += page->folded_window_count;
    all.next = page->next;
    more = page->records.size() == limit;
  }
  return all;
}

class EvidenceFoldingTest : public ::testing::Test {
 protected:
  EvidenceFoldingTest() {
    std::filesystem::create_directory(data_);
    Reopen();
  }
  void Reopen() {
    store_.reset();
    store_ = *OpenSqlitePriorStore(path_);
  }
  void Commit(const std::vector<SourceUpdate>& updates) {
    ASSERT_TRUE(store_->Commit(updates).ok());
  }
  int64_t Query(const std::string& sql) {
    auto file = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
    return *file.QueryInteger(sql);
  }
  void Execute(const std::string& sql) {
    auto file = *SqliteDatabase::Open(path_.string(), SqliteDatabase::OpenMode::kExisting);
    const absl::Status status = file.Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }
  // Checks the pages, hashes, sums and counts of the file.
  absl::StatusOr<StoreContents> Verify() { return VerifyStore(path_); }
  KeySum Sum(const std::string& arm) { return LoadSums(*store_, {Key(arm)})->sums[0]; }
  priors::SceneEvidence Harbour() { return **store_->LoadScene({"game", "harbour", "desktop", 1}); }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path data_ = directory_.path() / "data";
  std::filesystem::path path_ = data_ / "priors.db";
  std::unique_ptr<PriorStore> store_;
};

TEST_F(EvidenceFoldingTest, OldSessionsOfAMonthBecomeOneRowPerArmAndSumsStay) {
  // 20 November, 30 November and 10 December 2026, and today.
  Commit({At(kNowS - 56 * kDayS, Update("a", 1, {Key("Grid"), Key("SAP")})),
          At(kNowS - 46 * kDayS, Update("b", 1, {Key("Grid")})),
          At(kNowS - 36 * kDayS, Update("c", 1, {Key("Grid")})),
          At(kNowS, Update("d", 1, {Key("Grid")}))});
  const FoldStep done = FoldAll(*store_, kNowS - 30 * kDayS);
  EXPECT_EQ(done.source_count, 3u);
  EXPECT_EQ(done.record_count, 4u);
  EXPECT_EQ(Query("SELECT count(*) FROM evidence"), 4);  // Grid: two months and d; SAP: one
  EXPECT_EQ(Sum("Grid").evidence, (priors::Evidence{3.0, 1.0, 4, 8}));
  EXPECT_EQ(Sum("SAP").evidence, (priors::Evidence{0.75, 0.25, 1, 2}));
  EXPECT_EQ(Harbour().source_count, 4u);
  const auto contents = Verify();
  ASSERT_TRUE(contents.ok()) << contents.status();
  EXPECT_EQ(contents->source_count, 4);
  EXPECT_EQ(FoldAll(*store_, kNowS - 30 * kDayS).record_count, 0u);
}

TEST_F(EvidenceFoldingTest, WhatWasImportedOrHasNoTimeStays) {
  ASSERT_TRUE(store_->Import(std::vector{Record("i", 1, Key("Grid"), 4.0)}).ok());
  Commit({Update("before times were kept", 1, {Key("Grid")})});
  EXPECT_EQ(FoldAll(*store_, kNowS).record_count, 0u);
  EXPECT_EQ(ExportPages(*store_, 10).records.size(), 2u);
}

TEST_F(EvidenceFoldingTest, WhatASessionSendsAgainAfterwardsIsIgnoredAndWhatIsNewIsAdded) {
  Commit({At(1, Update("a", 1, {Key("Grid")})), At(1, Update("b", 1, {Key("Grid")}))});
  FoldAll(*store_, kNowS);
  Commit({At(kNowS, Update("a", 1, {Key("Grid")}))});
  EXPECT_EQ(Sum("Grid").evidence.window_count, 2u);
  const auto source = *store_->LoadSource("a");
  ASSERT_TRUE(source.has_value());
  EXPECT_EQ(source->progress, Update("a", 1, {}).progress);
  EXPECT_THAT(source->evidence, IsEmpty());
  EXPECT_TRUE(source->is_counted);
  Commit({At(kNowS, Update("a", 2, {Key("Grid")}))});
  EXPECT_EQ(Sum("Grid").evidence.window_count, 3u);
  EXPECT_EQ(Harbour().source_count, 2u);
  EXPECT_TRUE(Verify().ok()) << Verify().status();
  EXPECT_EQ(FoldAll(*store_, kNowS).source_count, 1u);
  EXPECT_EQ(Sum("Grid").evidence.window_count, 3u);
  EXPECT_TRUE(Verify().ok()) << Verify().status();
}

TEST_F(EvidenceFoldingTest, ImportsOfAFoldedSessionAreIgnored) {
  Commit({At(1, Update("a", 1, {Key("Grid")}))});
  const priors::ExportPage before = ExportPages(*store_, 10);
  FoldAll(*store_, kNowS);
  std::vector<PriorRecord> records = before.records;
  records[0].source_sequence = 9;
  EXPECT_EQ(store_->Import(records)->unchanged_count, 1u);
  EXPECT_EQ(Sum("Grid").evidence.window_count, 1u);
}

TEST_F(EvidenceFoldingTest, ExportsLeaveFoldedEvidenceOutAndSayHowMuch) {
  std::vector<SourceUpdate> updates;
  for (int i = 0; i < 5; ++i)
    updates.push_back(At(1, Update(std::to_string(i), 1, {Key("Grid"), Key("SAP"), Key("Tracy")})));
  updates.push_back(At(kNowS, Update("new", 1, {Key("Grid"), Key("SAP")})));
  Commit(updates);
  FoldAll(*store_, kDayS);
  for (const uint32_t limit : {1u, 2u, 3u, 100u}) {
    const priors::ExportPage all = ExportPages(*store_, limit);
    EXPECT_THAT(all.records, ElementsAre(::testing::Field(&PriorRecord::source_id, "new"),
                                         ::testing::Field(&PriorRecord::source_id, "new")));
    EXPECT_EQ(all.folded_record_count, 15u) << limit;
    EXPECT_EQ(all.folded_window_count, 15u) << limit;
  }
}

TEST_F(EvidenceFoldingTest, NobodyCanTakeTheNameOfFoldedEvidence) {
  Commit({At(1, Update("a", 1, {Key("Grid")}))});
  FoldAll(*store_, kNowS);
  const std::string name = "\nfolded 1970-01";
  EXPECT_EQ(Query("SELECT count(*) FROM source WHERE name = char(10) || 'folded 1970-01'"), 1);
  EXPECT_TRUE(absl::IsInvalidArgument(
      store_->Import(std::vector{Record(name, 9, Key("Grid"), 4.0)}).status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(store_->Commit(std::vector{At(1, Update(name, 9, {Key("Grid")}))})));
  EXPECT_EQ(*store_->LoadSource(name), std::nullopt);
}

TEST_F(EvidenceFoldingTest, RevokingASessionKeepsWhatWasFoldedOfIt) {
  Commit({At(1, Update("a", 1, {Key("Grid")})), At(1, Update("b", 1, {Key("Grid")}))});
  FoldAll(*store_, kNowS);
  Commit({At(kNowS, Update("c", 1, {Key("Grid")}))});
  EXPECT_EQ(store_->Revoke({.id = "a"}, false)->record_count, 0u);
  EXPECT_EQ(store_->Revoke({.id = "c"}, false)->record_count, 1u);
  EXPECT_EQ(Sum("Grid").evidence.window_count, 2u);
  EXPECT_EQ(Harbour().source_count, 2u);
  Commit({At(kNowS, Update("a", 2, {Key("Grid")}))});
  EXPECT_EQ(Sum("Grid").evidence.window_count, 2u);
  EXPECT_TRUE(Verify().ok()) << Verify().status();
}

TEST_F(EvidenceFoldingTest, ADamagedRowIsNeitherFoldedNorAddedTo) {
  Commit({At(1, Update("a", 1, {Key("Grid"), Key("SAP")})),
          At(1, Update("b", 1, {Key("Grid"), Key("SAP")}))});
  Execute("UPDATE evidence SET alpha = 7 WHERE key_id = 1 AND source_id = 1");
  EXPECT_EQ(FoldAll(*store_, kNowS).record_count, 3u);
  Execute("UPDATE evidence SET alpha = 9 WHERE key_id = 2");  // the folded row of SAP
  Commit({At(1, Update("c", 1, {Key("Grid"), Key("SAP")}))});
  EXPECT_EQ(FoldAll(*store_, kNowS).record_count, 1u);
  EXPECT_EQ(Query("SELECT count(*) FROM evidence WHERE hash <> content_hash"), 2);
  EXPECT_EQ(Query("SELECT count(*) FROM evidence"), 4);
}

TEST_F(EvidenceFoldingTest, AMonthGrowsToWhatARowMayHoldAndTheRestStaysInItsOwnRows) {
  std::vector<SourceUpdate> updates;
  for (const char* source : {"a", "b", "c"}) {
    updates.push_back(At(1, Update(source, 1, {Key("Grid")})));
    updates.back().increments[0].evidence.alpha = 4e14;
    updates.back().increments[0].evidence.window_count = 1ull << 61;
  }
  Commit(updates);
  EXPECT_EQ(FoldAll(*store_, kNowS).record_count, 2u);
  EXPECT_EQ(Sum("Grid").evidence.alpha, 1.2e15);
  EXPECT_TRUE(Verify().ok()) << Verify().status();
}

TEST_F(EvidenceFoldingTest, AStepThatFailsLeavesNothingOfItself) {
  Commit({At(1, Update("a", 1, {Key("Grid")})), At(1, Update("b", 1, {Key("Grid")}))});
  const auto before = ExportPages(*store_, 10).records;
  Execute(
      "CREATE TRIGGER disk BEFORE DELETE ON evidence WHEN old.source_id = 2 "
      "BEGIN SELECT raise(ABORT, 'no'); END");
  EXPECT_FALSE(FoldSources(*store_, {}, kNowS).ok());
  EXPECT_EQ(ExportPages(*store_, 10).records, before);
  EXPECT_EQ(Query("SELECT count(*) FROM source"), 2);
  Execute("DROP TRIGGER disk");
  EXPECT_EQ(FoldAll(*store_, kNowS).source_count, 2u);
}

TEST_F(EvidenceFoldingTest, SourcesOfAStepsBoundaryAreCountedOnce) {
  std::vector<SourceUpdate> updates;
  for (int i = 0; i < 600; ++i)
    updates.push_back(At(1, Update(std::to_string(i), 1, {Key("Grid"), Key("SAP"), Key("DBVT")})));
  Commit(updates);
  const auto first = FoldSources(*store_, {}, kNowS);
  EXPECT_EQ(first->record_count, 200u);
  EXPECT_FALSE(first->last);
  const FoldStep rest = FoldAll(*store_, kNowS, first->next);
  EXPECT_EQ(first->source_count + rest.source_count, 600u);
  EXPECT_EQ(first->record_count + rest.record_count, 1800u);
  Reopen();
  EXPECT_EQ(Sum("DBVT").evidence.window_count, 600u);
  EXPECT_EQ(Harbour().source_count, 600u);
  EXPECT_TRUE(Verify().ok()) << Verify().status();
}

TEST_F(EvidenceFoldingTest, ADaemonThatIsKilledMeanwhileLeavesAllSumsAsTheyWere) {
  std::vector<SourceUpdate> updates;
  for (int i = 0; i < 700; ++i)
    updates.push_back(At(1, Update(std::to_string(i), 1, {Key("Grid"), Key("SAP"), Key("DBVT")})));
  Commit(updates);
  store_.reset();
  for (int kill_after = 0; kill_after < 4; ++kill_after) {
    std::array<int, 2> steps{};
    ASSERT_EQ(pipe(steps.data()), 0);
    const pid_t child = fork();
    if (child == 0) {
      const auto store = *OpenSqlitePriorStore(path_);
      FoldPlace place;
      while (true) {
        const ssize_t told = write(steps[1], "x", 1);
        const auto step = FoldSources(*store, place, kNowS);
        if (told != 1 || !step.ok()) _exit(1);
        place = step->last ? FoldPlace{} : step->next;
      }
    }
    char one = 0;
    for (int i = 0; i <= kill_after; ++i) ASSERT_EQ(read(steps[0], &one, 1), 1);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(steps[0]);
    close(steps[1]);
    Reopen();
    for (const char* arm : {"Grid", "SAP", "DBVT"})
      EXPECT_EQ(Sum(arm).evidence, (priors::Evidence{525, 175, 700, 1400}));
    EXPECT_EQ(Harbour().source_count, 700u);
    EXPECT_TRUE(Verify().ok()) << Verify().status();
    store_.reset();
  }
  Reopen();
  FoldAll(*store_, kNowS);
  EXPECT_EQ(Query("SELECT count(*) FROM evidence"), 3);
}

// A store that folds, beside one that does not.
class FoldingHistory {
 public:
  FoldingHistory(PriorStore& store, uint64_t seed) : store_(store), random_(seed) {}

  // One step: new evidence, the same again, an import, or a fold.
  void Next() {
    ++step_;
    const uint64_t what = Pick(12);
    if (what == 0) {
      folded_ += FoldAll(store_, step_ * kDayS - Pick(60 * kDayS)).record_count;
    } else if (what == 1 && !updates_.empty()) {
      Commit(updates_[Pick(updates_.size())]);
    } else if (what < 4) {
      Import();
    } else {
      updates_.push_back(At(step_ * kDayS, Update(AnySource(), step_, {AnyKey()})));
      updates_.back().increments[0].evidence.alpha = 0.25 * static_cast<double>(Pick(100));
      Commit(updates_.back());
    }
  }
  void ExpectTheSame() {
    std::vector<EvidenceKey> keys;
    for (int i = 0; i < 9; ++i) keys.push_back(KeyOf(i));
    const auto sums = *LoadSums(store_, keys);
    const auto expected = *LoadSums(model_, keys);
    for (size_t i = 0; i < keys.size(); ++i)
      EXPECT_EQ(sums.sums[i].evidence, expected.sums[i].evidence) << i;
    EXPECT_EQ(sums.source_count, expected.source_count);
    for (int i = 0; i < 30; ++i) ExpectTheSameSource(std::to_string(i));
    const priors::ExportPage exported = ExportPages(store_, 7);
    const priors::ExportPage all = ExportPages(model_, 1000);
    EXPECT_EQ(Windows(exported) + exported.folded_window_count, Windows(all));
  }
  uint64_t folded() const { return folded_; }

 private:
  uint64_t Pick(uint64_t count) { return random_() % count; }
  std::string AnySource() { return std::to_string(Pick(10) + step_ / 20); }
  static EvidenceKey KeyOf(uint64_t i) {
    return Key("arm " + std::to_string(i % 3), "scene " + std::to_string(i / 3));
  }
  EvidenceKey AnyKey() { return KeyOf(Pick(9)); }
  void Commit(const SourceUpdate& update) {
    ASSERT_TRUE(store_.Commit({&update, 1}).ok());
    ASSERT_TRUE(model_.Commit({&update, 1}).ok());
  }
  void Import() {
    const std::string source = Pick(2) == 0 ? AnySource() : "import " + AnySource();
    const PriorRecord record =
        Record(source, Pick(step_) + 1, AnyKey(), 0.25 * static_cast<double>(Pick(100)));
    const auto done = store_.Import({&record, 1});
    const auto expected = model_.Import({&record, 1});
    EXPECT_EQ(done->applied_count, expected->applied_count);
  }
  void ExpectTheSameSource(const std::string& id) {
    const auto source = *store_.LoadSource(id);
    const auto expected = *model_.LoadSource(id);
    ASSERT_EQ(source.has_value(), expected.has_value()) << id;
    if (!source) return;
    EXPECT_EQ(source->progress, expected->progress);
    EXPECT_EQ(source->is_counted, expected->is_counted);
  }
  static uint64_t Windows(const priors::ExportPage& page) {
    uint64_t count = 0;
    for (const PriorRecord& record : page.records) count += record.evidence.window_count;
    return count;
  }

  PriorStore& store_;
  MemoryPriorStore model_;
  std::mt19937_64 random_;
  std::vector<SourceUpdate> updates_;
  uint64_t step_ = 0;
  uint64_t folded_ = 0;
};

TEST_F(EvidenceFoldingTest, AfterAnyHistoryItHasWhatAStoreHasThatNeverFolds) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    store_.reset();
    std::filesystem::remove_all(data_);
    std::filesystem::create_directory(data_);
    Reopen();
    FoldingHistory history(*store_, seed);
    for (int i = 1; i <= 400; ++i) {
      history.Next();
      if (i % 20 == 0) history.ExpectTheSame();
    }
    EXPECT_GT(history.folded(), 100u);
    EXPECT_TRUE(Verify().ok()) << Verify().status();
  }
}

TEST_F(EvidenceFoldingTest, ADaemonFoldsAtItsStartAndAfterEachInterval) {
  std::vector<SourceUpdate> fresh;  // more than a step
  for (int i = 0; i < 250; ++i)
    fresh.push_back(At(kNowS, Update(std::to_string(i), 1, {Key("Grid")})));
  Commit(fresh);
  Commit({At(kNowS - 11 * kDayS, Update("old", 1, {Key("Grid")})),
          At(kNowS - 9 * kDayS, Update("new", 1, {Key("Grid")}))});
  StoreThread thread(std::move(store_));
  std::atomic<uint64_t> now_s = kNowS;
  std::promise<FoldRun> first;
  std::promise<FoldRun> second;
  int runs = 0;
  FoldPlan plan{.days = 10, .interval = std::chrono::milliseconds(1), .pause = {}};
  EvidenceFolding folding(
      thread, plan, [&] { return now_s.load(); },
      [&](const FoldRun& run) {
        now_s = kNowS + 2 * kDayS;
        if (++runs <= 2) (runs == 1 ? first : second).set_value(run);
      });
  const FoldRun at_start = first.get_future().get();
  EXPECT_TRUE(at_start.status.ok()) << at_start.status;
  EXPECT_EQ(at_start.source_count, 1u);
  EXPECT_EQ(second.get_future().get().source_count, 1u);
}

TEST_F(EvidenceFoldingTest, ARunThatTheStoreRefusesSaysSoAndZeroDaysFoldNothing) {
  StoreThread thread(std::move(store_));
  thread.Close();
  std::promise<FoldRun> told;
  FoldPlan plan{.days = 10, .pause = {}};
  const auto now = [] { return kNowS; };
  const EvidenceFolding folding(thread, plan, now,
                                [&](const FoldRun& run) { told.set_value(run); });
  EXPECT_TRUE(absl::IsUnavailable(told.get_future().get().status));
  plan = {.days = 0, .interval = {}, .pause = {}};
  const auto never = [] {
    ADD_FAILURE();
    return kNowS;
  };
  const EvidenceFolding none(thread, plan, never, [](const FoldRun&) { ADD_FAILURE(); });
}

}  // namespace
}  // namespace sweepstake::storage
