// Tests group commits: which callbacks run, and when.
#include "server/storage/store_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <future>

#include "tests/server/storage/evidence_samples.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::storage {
namespace {

using std::chrono::milliseconds;

// Counts commits, and fails them on request. Changed on the store's thread, or before it starts.
class CountingStore final : public ForwardingStore {
 public:
  explicit CountingStore(std::vector<size_t>& group_sizes, bool& failing, bool& misplaced)
      : group_sizes_(group_sizes), failing_(failing), misplaced_(misplaced) {}

  absl::Status Commit(std::span<const SourceUpdate> updates) override {
    if (failing_) return absl::UnavailableError("the disk is full");
    group_sizes_.push_back(updates.size());
    return ForwardingStore::Commit(updates);
  }
  absl::Status CheckPlace() override {
    return misplaced_ ? absl::NotFoundError("the file is gone") : absl::OkStatus();
  }

 private:
  std::vector<size_t>& group_sizes_;
  bool& failing_;
  bool& misplaced_;
};

class StoreThreadTest : public ::testing::Test {
 protected:
  void Start(StoreThreadOptions options) {
    thread_ = std::make_unique<StoreThread>(
        std::make_unique<CountingStore>(group_sizes_, failing_, misplaced_), options);
  }
  void OnThread(const std::function<void()>& task) {
    std::promise<void> done;
    thread_->Submit([&](PriorStore&) {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  // Keeps the thread busy until the returned promise is set.
  std::shared_ptr<std::promise<void>> Occupy() {
    auto release = std::make_shared<std::promise<void>>();
    auto started = std::make_shared<std::promise<void>>();
    thread_->Submit([release, started](PriorStore&) {
      started->set_value();
      release->get_future().wait();
    });
    started->get_future().wait();
    return release;
  }
  std::future<absl::Status> Commit(const SourceUpdate& update) {
    auto promise = std::make_shared<std::promise<absl::Status>>();
    thread_->Commit(update, [promise](const absl::Status& status) { promise->set_value(status); });
    return promise->get_future();
  }

  std::vector<size_t> group_sizes_;
  bool failing_ = false;
  bool misplaced_ = false;
  std::unique_ptr<StoreThread> thread_;
};

TEST_F(StoreThreadTest, ItsOwnThreadHasALowerPriorityThanTheThreadsThatAnswerGames) {
  Start({});
  int niceness = 0;
  OnThread([&] { niceness = getpriority(PRIO_PROCESS, 0); });
  EXPECT_GT(niceness, getpriority(PRIO_PROCESS, 0));
}

TEST_F(StoreThreadTest, ConcurrentUpdatesShareACommit) {
  Start({.group_interval = milliseconds(0)});
  const auto release = Occupy();
  auto a = Commit(Update("a", 1, {Key("Grid")}));
  auto b = Commit(Update("b", 1, {Key("Grid")}));
  release->set_value();
  EXPECT_TRUE(a.get().ok());
  EXPECT_TRUE(b.get().ok());
  thread_->Close();
  EXPECT_THAT(group_sizes_, ::testing::ElementsAre(2));
}

TEST_F(StoreThreadTest, WithoutAThreadItsOwnerRunsGroupsAndJobs) {
  Start({.own_thread = false});
  auto a = Commit(Update("a", 1, {Key("Grid")}));
  auto b = Commit(Update("b", 1, {Key("Grid")}));
  bool ran = false;
  thread_->Submit([&](PriorStore&) { ran = true; });
  EXPECT_EQ(thread_->queued_count(), 3U);
  EXPECT_TRUE(thread_->RunNext());
  EXPECT_TRUE(a.get().ok());
  EXPECT_TRUE(b.get().ok());
  EXPECT_FALSE(ran);
  EXPECT_TRUE(thread_->RunNext());
  EXPECT_TRUE(ran);
  EXPECT_FALSE(thread_->RunNext());
  auto last = Commit(Update("a", 2, {Key("Grid")}));
  thread_->Close();
  EXPECT_TRUE(last.get().ok());
}

TEST_F(StoreThreadTest, EachCommitOfTheStoreIsTimed) {
  std::vector<std::chrono::nanoseconds> durations;
  Start({.group_interval = milliseconds(0),
         .on_commit = [&](auto taken) { durations.push_back(taken); }});
  EXPECT_TRUE(Commit(Update("a", 1, {Key("Grid")})).get().ok());
  EXPECT_TRUE(Commit(Update("a", 2, {Key("Grid")})).get().ok());
  thread_->Close();
  ASSERT_EQ(durations.size(), 2u);
  EXPECT_GT(durations[0].count(), 0);
}

TEST_F(StoreThreadTest, AFullGroupDoesNotWaitForItsInterval) {
  Start({.group_interval = std::chrono::hours(1), .group_rows = 2});
  EXPECT_TRUE(Commit(Update("a", 1, {Key("Grid")})).get().ok());
}

TEST_F(StoreThreadTest, AJobSeesTheCommitsOfferedBeforeIt) {
  Start({.group_interval = milliseconds(0)});
  Commit(Update("a", 1, {Key("Grid")}));
  std::promise<uint64_t> seen;
  thread_->Submit(
      [&](PriorStore& store) { seen.set_value(LoadSums(store, {Key("Grid")})->source_count); });
  EXPECT_EQ(seen.get_future().get(), 1u);
}

TEST_F(StoreThreadTest, AJobDoesNotSplitAGroupAndSeesItsLaterCommits) {
  Start({.own_thread = false});
  Commit(Update("a", 1, {Key("Grid")}));
  uint64_t seen = 0;
  thread_->Submit([&](PriorStore& store) { seen = LoadSums(store, {Key("Grid")})->source_count; });
  Commit(Update("b", 1, {Key("Grid")}));
  while (thread_->RunNext()) continue;
  EXPECT_THAT(group_sizes_, ::testing::ElementsAre(2));
  EXPECT_EQ(seen, 2u);
}

TEST_F(StoreThreadTest, AJobWaitsForAllEarlierGroupsAndNoLaterOne) {
  Start({.group_rows = 2, .own_thread = false});
  for (uint64_t i = 1; i <= 2; ++i) Commit(Update("a", i, {Key("Grid")}));
  std::vector<size_t> before;
  thread_->Submit([&](PriorStore&) { before = group_sizes_; });
  for (uint64_t i = 3; i <= 6; ++i) Commit(Update("a", i, {Key("Grid")}));
  while (thread_->RunNext()) continue;
  EXPECT_THAT(before, ::testing::ElementsAre(1, 1));
  EXPECT_THAT(group_sizes_, ::testing::ElementsAre(1, 1, 1, 1, 1, 1));
}

TEST_F(StoreThreadTest, OneInvalidUpdateDoesNotFailItsGroup) {
  Start({.group_interval = milliseconds(0)});
  const auto release = Occupy();
  auto good = Commit(Update("a", 1, {Key("Grid")}));
  auto wrong = Commit(Update("b", 0, {Key("Grid")}));
  release->set_value();
  EXPECT_TRUE(good.get().ok());
  EXPECT_TRUE(absl::IsInvalidArgument(wrong.get()));
  EXPECT_TRUE(thread_->healthy());
}

TEST_F(StoreThreadTest, AGroupWithAnInvalidUpdateIsHalvedUntilTheUpdateIsAlone) {
  std::vector<std::string> refused;
  Start({.group_interval = milliseconds(0),
         .on_refusal = [&](const SourceUpdate& update, const absl::Status& status) {
           EXPECT_TRUE(absl::IsInvalidArgument(status));
           refused.push_back(update.progress.source_id);
         }});
  const auto release = Occupy();
  std::vector<std::future<absl::Status>> commits;
  for (int i = 0; i < 32; ++i) {
    const uint64_t sequence = i == 21 ? 0 : 1;  // 0 is not a valid commit sequence
    commits.push_back(Commit(Update("source " + std::to_string(i), sequence, {Key("Grid")})));
  }
  release->set_value();
  for (size_t i = 0; i < commits.size(); ++i) EXPECT_EQ(commits[i].get().ok(), i != 21) << i;
  thread_->Close();
  EXPECT_THAT(refused, ::testing::ElementsAre("source 21"));
  EXPECT_THAT(group_sizes_, ::testing::ElementsAre(32, 16, 16, 8, 4, 4, 2, 1, 1, 2, 8));
}

TEST_F(StoreThreadTest, AFullDiskIsReportedAndUnhealthyUntilACommitSucceeds) {
  failing_ = true;
  std::vector<absl::Status> told;
  Start({.group_interval = milliseconds(0),
         .on_health = [&](const absl::Status& status) { told.push_back(status); }});
  EXPECT_TRUE(absl::IsUnavailable(Commit(Update("a", 1, {})).get()));
  EXPECT_TRUE(absl::IsUnavailable(Commit(Update("a", 1, {})).get()));
  EXPECT_FALSE(thread_->healthy());
  OnThread([&] { failing_ = false; });
  EXPECT_TRUE(Commit(Update("a", 1, {})).get().ok());
  EXPECT_TRUE(Commit(Update("a", 2, {})).get().ok());
  EXPECT_TRUE(thread_->healthy());
  ASSERT_EQ(told.size(), 2u) << "each reported once";
  EXPECT_EQ(told[0].message(), "the disk is full");
  EXPECT_TRUE(told[1].ok());
}

TEST_F(StoreThreadTest, AMisplacedStoreIsDetectedWithoutCommitsReportedOnceAndSaved) {
  std::vector<absl::Status> told;
  std::atomic<int> saved_count = 0;
  Start({.check_interval = milliseconds(1),
         .on_health = [&](const absl::Status& status) { told.push_back(status); },
         .on_misplaced = [&](PriorStore&, bool /*last*/) { ++saved_count; }});
  OnThread([&] { misplaced_ = true; });
  while (saved_count < 3) std::this_thread::yield();
  EXPECT_FALSE(thread_->healthy());
  OnThread([&] { misplaced_ = false; });
  while (!thread_->healthy()) std::this_thread::yield();
  thread_->Close();
  ASSERT_EQ(told.size(), 2u) << "each reported once";
  EXPECT_TRUE(absl::IsNotFound(told[0]));
  EXPECT_TRUE(told[1].ok());
}

TEST_F(StoreThreadTest, AMisplacedStoreIsReportedBeforeTheFailedCommitThatDetectsIt) {
  std::vector<absl::Status> told;
  bool saved = false;
  Start({.group_interval = milliseconds(0),
         .check_interval = std::chrono::hours(1),
         .on_health = [&](const absl::Status& status) { told.push_back(status); },
         .on_misplaced = [&](PriorStore&, bool last) { saved = !last; }});
  OnThread([&] { failing_ = misplaced_ = true; });
  EXPECT_TRUE(absl::IsUnavailable(Commit(Update("a", 1, {})).get()));
  EXPECT_TRUE(saved);
  thread_->Close();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].message(), "the file is gone");
}

TEST_F(StoreThreadTest, AStoreMisplacedDuringADiskFailureIsReportedAndStaysUnhealthyWhenItIsBack) {
  std::vector<absl::StatusCode> told;
  std::atomic<int> told_count = 0;
  Start({.group_interval = milliseconds(0),
         .check_interval = milliseconds(1),
         .on_health = [&](const absl::Status& status) {
           told.push_back(status.code());
           ++told_count;
         }});
  const auto set = [&](bool misplaced, int count) {
    OnThread([&] { misplaced_ = misplaced; });
    while (told_count < count) std::this_thread::yield();
    EXPECT_FALSE(thread_->healthy());
  };
  OnThread([&] { failing_ = true; });
  EXPECT_FALSE(Commit(Update("a", 1, {})).get().ok());
  set(true, 2);
  EXPECT_FALSE(Commit(Update("a", 1, {})).get().ok());
  set(false, 3);
  OnThread([&] { failing_ = false; });
  EXPECT_TRUE(Commit(Update("a", 1, {})).get().ok());
  EXPECT_TRUE(thread_->healthy());
  thread_->Close();
  using enum absl::StatusCode;
  EXPECT_THAT(told, ::testing::ElementsAre(kUnavailable, kNotFound, kUnavailable, kOk));
}

TEST_F(StoreThreadTest, AStoreMisplacedAgainAfterACommitIsReportedAgain) {
  std::vector<absl::StatusCode> told;
  Start({.group_interval = milliseconds(0),
         .check_interval = std::chrono::hours(1),
         .on_health = [&](const absl::Status& status) { told.push_back(status.code()); }});
  for (const bool misplaced : {true, false, true}) {
    OnThread([&] { failing_ = misplaced_ = misplaced; });
    EXPECT_EQ(Commit(Update("a", told.size() + 1, {})).get().ok(), !misplaced);
    EXPECT_EQ(thread_->healthy(), !misplaced);
  }
  thread_->Close();
  using enum absl::StatusCode;
  EXPECT_THAT(told, ::testing::ElementsAre(kNotFound, kOk, kNotFound));
}

TEST_F(StoreThreadTest, AMisplacedStoreIsDetectedAtShutdownAtTheLatest) {
  bool saved = false;
  Start({.check_interval = std::chrono::hours(1),
         .on_misplaced = [&](PriorStore&, bool last) { saved = last; }});
  OnThread([&] { misplaced_ = true; });
  thread_->Close();
  EXPECT_TRUE(saved);
}

TEST_F(StoreThreadTest, TheStoreIsCheckedWithoutCommitsAndAtShutdown) {
  std::atomic<int> look_count = 0;
  const auto look = [&](PriorStore&) { ++look_count; };
  Start({.check_interval = milliseconds(1), .on_check = look});
  while (look_count < 3) std::this_thread::yield();
  thread_->Close();
  look_count = 0;
  Start({.check_interval = std::chrono::hours(1), .on_check = look});
  EXPECT_EQ(look_count, 0);
  thread_->Close();
  EXPECT_EQ(look_count, 1);
}

TEST_F(StoreThreadTest, AFullQueueRefusesAtOnce) {
  Start({.group_interval = milliseconds(0), .max_queued = 1});
  const auto release = Occupy();
  auto queued = Commit(Update("a", 1, {}));
  EXPECT_TRUE(absl::IsResourceExhausted(Commit(Update("b", 1, {})).get()));
  EXPECT_FALSE(thread_->Submit([](PriorStore&) {}));
  release->set_value();
  EXPECT_TRUE(queued.get().ok());
}

TEST_F(StoreThreadTest, ClosingDoesNotRetryEachUpdateOnAFailingDisk) {
  failing_ = true;
  Start({.group_interval = milliseconds(0), .group_rows = 1});
  EXPECT_TRUE(absl::IsUnavailable(Commit(Update("a", 1, {})).get()));
  const auto release = Occupy();
  failing_ = false;  // a commit would succeed now
  auto a = Commit(Update("a", 1, {}));
  auto b = Commit(Update("b", 1, {}));
  std::thread closer([&] { thread_->Close(); });
  while (thread_->Submit([](PriorStore&) {})) std::this_thread::yield();
  release->set_value();
  closer.join();
  EXPECT_TRUE(absl::IsUnavailable(a.get()));
  EXPECT_TRUE(absl::IsUnavailable(b.get()));
  EXPECT_TRUE(group_sizes_.empty());
}

TEST_F(StoreThreadTest, ClosingCommitsQueuedUpdatesAndRefusesLaterOnes) {
  Start({.group_interval = std::chrono::hours(1)});
  auto queued = Commit(Update("a", 1, {}));
  thread_->Close();
  EXPECT_TRUE(queued.get().ok());
  EXPECT_TRUE(absl::IsResourceExhausted(Commit(Update("b", 1, {})).get()));
}

}  // namespace
}  // namespace sweepstake::storage
