// Tests reads concurrent with the commits of a store: neither waits for the other, and each read
// sees one state.
#include "server/storage/read_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "server/storage/sqlite_prior_store.h"
#include "server/storage/store_thread.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::storage {
namespace {

using priors::PriorReader;
using std::chrono::milliseconds;

class ReadThreadTest : public ::testing::Test {
 protected:
  void Start(StoreThreadOptions options = {.group_interval = milliseconds(0)}) {
    auto store = *OpenSqlitePriorStore(path_);
    auto reads = *OpenSqliteReadConnection(path_);
    thread_ = std::make_unique<StoreThread>(std::move(store), std::move(options), std::move(reads));
  }
  std::future<absl::Status> Commit(const SourceUpdate& update) {
    auto promise = std::make_shared<std::promise<absl::Status>>();
    thread_->Commit(update, [promise](const absl::Status& status) { promise->set_value(status); });
    return promise->get_future();
  }
  // Returns the result of `read`.
  template <typename Result>
  std::future<Result> Read(std::function<Result(PriorReader&)> read) {
    auto promise = std::make_shared<std::promise<Result>>();
    EXPECT_TRUE(
        thread_->Read([promise, read](PriorReader& store) { promise->set_value(read(store)); }));
    return promise->get_future();
  }
  static uint64_t SourceCount(PriorReader& store) {
    return LoadSums(store, {Key("Grid")})->source_count;
  }
  uintmax_t LogBytes() const { return std::filesystem::file_size(path_.string() + "-wal"); }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "priors.db";
  std::unique_ptr<StoreThread> thread_;
};

TEST_F(ReadThreadTest, ACommitDoesNotWaitForAHangingReadWhichIsReported) {
  Start({.group_interval = milliseconds(0), .max_read = milliseconds(0)});
  ASSERT_TRUE(Commit(Update("a", 1, {Key("Grid")})).get().ok());
  EXPECT_TRUE(thread_->healthy());
  std::promise<void> release;
  std::promise<void> begun;
  auto hanging = Read<uint64_t>([&](PriorReader& store) {
    const uint64_t count = SourceCount(store);
    begun.set_value();
    release.get_future().wait();
    return count;
  });
  begun.get_future().wait();
  auto behind = Read<uint64_t>(&SourceCount);
  for (uint64_t n = 2; n <= 50; ++n) {
    auto commit = Commit(Update("a", n, {Key("Grid")}));
    ASSERT_EQ(commit.wait_for(std::chrono::seconds(20)), std::future_status::ready);
    EXPECT_TRUE(commit.get().ok());
  }
  EXPECT_FALSE(thread_->healthy());
  EXPECT_TRUE(thread_->can_write());
  EXPECT_EQ(thread_->queued_read_count(), 1u);
  release.set_value();
  EXPECT_EQ(behind.get(), 1u);
  thread_->Close();
  EXPECT_TRUE(thread_->healthy());
}

TEST_F(ReadThreadTest, AReadSeesOneStateAndTheNextSeesAcknowledgedCommits) {
  Start();
  ASSERT_TRUE(Commit(Update("a", 1, {Key("Grid")})).get().ok());
  std::promise<void> committed;
  std::promise<void> begun;
  auto counts = Read<std::vector<uint64_t>>([&](PriorReader& store) {
    std::vector<uint64_t> seen = {SourceCount(store)};
    begun.set_value();
    committed.get_future().wait();
    seen.push_back(SourceCount(store));
    seen.push_back(store.Export({}, {}, 9)->records.size());
    return seen;
  });
  begun.get_future().wait();
  EXPECT_TRUE(Commit(Update("b", 1, {Key("Grid")})).get().ok());
  committed.set_value();
  EXPECT_THAT(counts.get(), ::testing::ElementsAre(1, 1, 1));
  EXPECT_EQ(Read<uint64_t>(&SourceCount).get(), 2u);
}

TEST_F(ReadThreadTest, AnExportDuringCommitsSeesOneCommitPerSourceAndMatchingSums) {
  Start();
  std::atomic<bool> done = false;
  std::thread game([&] {
    for (uint64_t n = 1; n <= 300; ++n) {
      const std::string source = std::to_string(n % 7);
      EXPECT_TRUE(Commit(Update(source, n, {Key("Grid"), Key("SAP")})).get().ok());
    }
    done = true;
  });
  uint64_t read_count = 0;
  for (bool last = false; !last; ++read_count) {
    last = done;
    Read<bool>([](PriorReader& store) {
      std::map<std::string, std::set<uint64_t>> sequences;
      uint64_t windows = 0;
      priors::ExportPage page;
      do {
        page = *store.Export({}, page.next, 3);
        for (const PriorRecord& record : page.records) {
          sequences[record.source_id].insert(record.source_sequence);
          windows += record.evidence.window_count;
        }
      } while (!page.records.empty());
      for (const auto& [source, of_source] : sequences) EXPECT_EQ(of_source.size(), 1u) << source;
      uint64_t summed = 0;
      const auto sums = *LoadSums(store, {Key("Grid"), Key("SAP")});
      for (const auto& sum : sums.sums) summed += sum.evidence.window_count;
      EXPECT_EQ(windows, summed);
      return true;
    }).get();
  }
  game.join();
  EXPECT_GT(read_count, 1u);
}

// Each read lasts until a commit has been made, and the next one follows at once, so that every
// commit overlaps a read.
TEST_F(ReadThreadTest, ContinuousReadsDoNotLetTheLogGrowForever) {
  Start();
  std::vector<EvidenceKey> keys;
  for (int i = 0; i < 100; ++i)
    keys.push_back(Key("arm " + std::to_string(i) + std::string(90, 'x')));
  std::mutex mutex;
  std::condition_variable changed;
  uint64_t commit_count = 0;  // guarded by mutex
  bool done = false;          // guarded by mutex
  std::function<void(PriorReader&)> read = [&](PriorReader& store) {
    EXPECT_TRUE(store.List({}, std::nullopt, 1).ok());
    std::unique_lock lock(mutex);
    if (!done) thread_->Read(read);
    changed.wait(lock, [&, before = commit_count] { return done || commit_count > before; });
  };
  ASSERT_TRUE(thread_->Read(read));
  uintmax_t bytes_of_40 = 0;
  for (uint64_t n = 1; n <= 600; ++n) {
    ASSERT_TRUE(Commit(Update("a", n, keys)).get().ok());
    if (n == 40) bytes_of_40 = LogBytes();
    const std::lock_guard lock(mutex);
    commit_count = n;
    changed.notify_all();
  }
  {
    const std::lock_guard lock(mutex);
    done = true;
  }
  changed.notify_all();
  EXPECT_LT(LogBytes(), 8 * bytes_of_40);
  thread_->Close();
}

TEST_F(ReadThreadTest, ClosingRunsQueuedReadsAndCheckpointsTheLog) {
  Start();
  ASSERT_TRUE(Commit(Update("a", 1, {Key("Grid")})).get().ok());
  std::promise<void> release;
  auto first = Read<bool>([&](PriorReader&) {
    release.get_future().wait();
    return true;
  });
  auto second = Read<uint64_t>(&SourceCount);
  std::thread closer([&] { thread_->Close(); });
  while (thread_->Read([](PriorReader&) {})) std::this_thread::yield();
  release.set_value();
  closer.join();
  EXPECT_EQ(second.get(), 1u);
  EXPECT_FALSE(thread_->Read([](PriorReader&) {}));
  thread_.reset();
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-wal"))
      << "a reading connection cannot do this, so it must not be closed last";
}

TEST_F(ReadThreadTest, TheDurationOfAReadIncludesItsTimeInTheQueue) {
  std::vector<std::chrono::nanoseconds> durations;
  Start({.own_thread = false, .on_read = [&](auto taken) { durations.push_back(taken); }});
  auto waiting = Read<uint64_t>(&SourceCount);
  EXPECT_EQ(thread_->queued_read_count(), 1u);
  EXPECT_TRUE(thread_->RunNextRead());
  EXPECT_FALSE(thread_->RunNextRead());
  EXPECT_EQ(waiting.get(), 0u);
  ASSERT_EQ(durations.size(), 1u);
  EXPECT_GT(durations[0].count(), 0);
}

TEST_F(ReadThreadTest, AFullQueueRefusesReadsButNoCommits) {
  Start({.own_thread = false, .max_queued = 1});
  EXPECT_TRUE(thread_->Read([](PriorReader&) {}));
  EXPECT_FALSE(thread_->Read([](PriorReader&) {}));
  EXPECT_TRUE(thread_->Submit([](PriorStore&) {}));
}

class ReadsOfAFailingDiskTest : public ::testing::Test {
 protected:
  void SetUp() override { Begin("first"); }
  void Begin(const std::string& name) {
    reads_.reset();
    store_.reset();
    path_ = directory_.path() / name / "priors.db";
    std::filesystem::create_directory(path_.parent_path());
    store_ = *OpenSqlitePriorStore(path_);
    reads_ = *OpenSqliteReadConnection(path_);
  }
  // Reopens the reading connection, to drop SQLite's cache.
  void OpenReadsAnew() {
    reads_.reset();
    reads_ = *OpenSqliteReadConnection(path_);
  }
  absl::Status Load() {
    const auto priors = LoadSums(reads_->Begin(), {Key("Grid")});
    reads_->End();
    return priors.status();
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path path_;
  FailingDisk disk_;
  std::unique_ptr<PriorStore> store_;
  std::unique_ptr<ReadConnection> reads_;
};

TEST_F(ReadsOfAFailingDiskTest, ContinueWhileTheDiskCannotBeWritten) {
  const FailingDisk::Faults faults[] = {
      {.write_error = 1}, {.sync_error = 1}, {.full = true}, {.read_only = true}};
  for (size_t i = 0; i < std::size(faults); ++i) {
    disk_.Set({});
    Begin(std::to_string(i));
    ASSERT_TRUE(store_->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
    disk_.Set(faults[i]);
    EXPECT_FALSE(store_->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
    EXPECT_EQ(Load(), absl::OkStatus());
    OpenReadsAnew();
    EXPECT_EQ(Load(), absl::OkStatus());
    EXPECT_EQ((*reads_->Begin().LoadSource("a"))->progress.commit_sequence, 1u)
        << "data that are not durable are not visible";
    reads_->End();
  }
}

TEST_F(ReadsOfAFailingDiskTest, DoNotCountAsDamageWhenTheyFail) {
  ASSERT_TRUE(store_->Commit(std::vector{Update("a", 1, {Key("Grid")})}).ok());
  OpenReadsAnew();
  ASSERT_TRUE(store_->Commit(std::vector{Update("a", 2, {Key("Grid")})}).ok());
  disk_.Set({.read_error = 1});
  EXPECT_TRUE(absl::IsUnavailable(Load())) << Load();
  disk_.Set({});
  EXPECT_EQ(Load(), absl::OkStatus());
}

TEST_F(ReadsOfAFailingDiskTest, EveryPageOfAnExportReadsTheSameAmount) {
  std::vector<SourceUpdate> updates;
  for (int source = 0; source < 5'000; ++source)
    updates.push_back(Update(std::to_string(source), 1, {Key("Grid"), Key("SAP")}));
  ASSERT_TRUE(store_->Commit(updates).ok());
  const priors::ExportPlace middle = reads_->Begin().Export({}, {}, 7'500)->next;
  reads_->End();
  for (const priors::ExportPlace& place : {priors::ExportPlace{}, middle}) {
    OpenReadsAnew();
    ASSERT_EQ(Load(), absl::OkStatus());
    const uint64_t before = disk_.read_count();
    EXPECT_EQ(reads_->Begin().Export({}, place, 10)->records.size(), 10u);
    reads_->End();
    EXPECT_LT(disk_.read_count() - before, 30u);
  }
}

}  // namespace
}  // namespace sweepstake::storage
