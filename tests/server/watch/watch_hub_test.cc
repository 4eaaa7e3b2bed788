// The hub against a memory store, on a loop that the test turns by hand.
#include "server/watch/watch_hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <utility>

#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::watch {
namespace {

using priors::SceneEvidence;
using priors::SceneKey;
using ::testing::IsEmpty;

SceneKey Scene(const std::string& name) { return {"game", name, "", 1}; }

// Runs jobs when the test says so.
class ManualStore final : public priors::AsyncPriorStore {
 public:
  void Commit(priors::SourceUpdate update, CommitCallback done) override {
    done(store_.Commit({&update, 1}));
  }
  bool Submit(Job job) override {
    ++submit_count;
    if (!full) jobs_.push_back(std::move(job));
    return !full;
  }
  bool Read(ReadJob /*job*/) override { return false; }
  bool healthy() const override { return true; }
  uint64_t lost_audit_row_count() const override { return 0; }
  void RunJobs() {
    for (; !jobs_.empty(); jobs_.pop_front()) jobs_.front()(store_);
  }
  SceneEvidence Load(const SceneKey& key) { return **store_.LoadScene(key); }

  size_t submit_count = 0;
  bool full = false;
  absl::Status read_status;

 private:
  // Reads a scene only if the test lets it.
  class Store final : public storage::ForwardingStore {
   public:
    explicit Store(const absl::Status& read_status) : read_status_(read_status) {}
    absl::StatusOr<std::optional<SceneEvidence>> LoadScene(const SceneKey& key) override {
      if (!read_status_.ok()) return read_status_;
      return ForwardingStore::LoadScene(key);
    }

   private:
    const absl::Status& read_status_;
  };

  Store store_{read_status};
  std::deque<Job> jobs_;
};

class RecordingListener final : public WatchListener {
 public:
  bool Watches(const SceneKey& scene) override { return scene.scene != "unwatched"; }
  void OnDecision(const sessions::DecisionEvent&) override { ++decision_count; }
  void OnTick() override { decisions_told = decision_count; }
  void OnPosterior(const SceneEvidence& scene) override { posteriors.push_back(scene); }
  void OnReset() override { ++reset_count; }

  std::vector<SceneEvidence> posteriors;
  int reset_count = 0;
  int decision_count = 0;
  int decisions_told = 0;
};

class WatchHubTest : public ::testing::Test {
 protected:
  WatchHubTest() { hub_.Add(listener_); }

  // A session commits one window's evidence, and a visit's of another arm, and the hub is told.
  void Commit(const std::string& scene, const std::string& source, uint64_t n = 1,
              const std::string& arm = "Grid") {
    priors::SourceUpdate update;
    update.progress.source_id = source;
    update.progress.commit_sequence = n;
    update.increments.push_back(
        {{.project = "game", .scene = scene, .measured_by = {}, .arm = arm, .machine_class = {}},
         {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 0}});
    update.increments.push_back(update.increments.back());
    update.increments.back().key.arm = "KDTree";
    update.increments.back().key.measured_by = "lane";
    store_.Commit(update, [](const absl::Status& status) { ASSERT_TRUE(status.ok()); });
    hub_.OnEvidence(Scene(scene), update.increments, /*new_source=*/n == 1);
  }
  // Runs the timers that wait, of which there is at most one, and returns how many there were.
  size_t Tick() {
    std::deque<std::function<void()>> due;
    due.swap(timers_);
    for (const auto& task : due) task();
    return due.size();
  }

  ManualStore store_;
  std::deque<std::function<void()>> timers_;
  RecordingListener listener_;
  WatchHub hub_{store_,
                {.post = [](const std::function<void()>& task) { task(); },
                 .post_after =
                     [this](int64_t delay_ns, std::function<void()> task) {
                       EXPECT_EQ(delay_ns, 250'000'000);
                       timers_.push_back(std::move(task));
                     }}};
};

TEST_F(WatchHubTest, AThousandCommitsReadEachSceneOnceAndAddUpToTheStore) {
  for (uint64_t n = 1; n <= 1000; ++n) {
    const std::string scene = std::to_string(n % 4);
    Commit(scene, scene + " " + std::to_string(n % 8), (n + 7) / 8, n % 3 == 0 ? "SAP" : "Grid");
    if (n % 100 == 0) store_.RunJobs();
    if (n % 100 == 50) Tick();
  }
  Tick();
  EXPECT_EQ(store_.submit_count, 4U);
  for (auto last = listener_.posteriors.end() - 4; last != listener_.posteriors.end(); ++last) {
    const SceneEvidence stored = store_.Load(last->key);
    EXPECT_EQ(last->source_count, stored.source_count);
    ASSERT_EQ(last->arms.size(), stored.arms.size());
    for (size_t i = 0; i < stored.arms.size(); ++i) {
      EXPECT_EQ(last->arms[i].name, stored.arms[i].name);
      EXPECT_EQ(last->arms[i].live, stored.arms[i].live);
      EXPECT_EQ(last->arms[i].lane, stored.arms[i].lane);
      EXPECT_GT(last->arms[i].last_seen_unix_s, 0u) << "when the hub was told";
    }
  }
}

TEST_F(WatchHubTest, ASceneIsToldOncePerTickAndNothingRunsWhileNothingChanges) {
  for (uint64_t n = 1; n <= 20; ++n) {
    Commit("a", "s", n);
    Commit("b", "t", n);
    store_.RunJobs();
  }
  EXPECT_THAT(listener_.posteriors, IsEmpty());
  EXPECT_EQ(Tick(), 1U);
  EXPECT_EQ(listener_.posteriors.size(), 2U);
  EXPECT_EQ(Tick(), 0U);
  Commit("b", "t", 21);
  EXPECT_EQ(Tick(), 1U);
  ASSERT_EQ(listener_.posteriors.size(), 3U);
  EXPECT_EQ(listener_.posteriors[2].key.scene, "b");
  EXPECT_EQ(listener_.posteriors[2].arms[0].live.window_count, 21U);
}

TEST_F(WatchHubTest, DecisionsHaveATickToBeToldAt) {
  const decision::DecisionRecord record;
  sessions::SessionIdentity session;
  const sessions::DecisionEvent decision{.session = session, .record = record};
  session.scene = Scene("a");
  hub_.OnDecision(decision);
  hub_.OnDecision(decision);
  session.scene = Scene("unwatched");
  hub_.OnDecision(decision);
  EXPECT_EQ(listener_.decisions_told, 0);
  EXPECT_EQ(Tick(), 1U);
  EXPECT_EQ(listener_.decisions_told, 2);
  EXPECT_EQ(Tick(), 0U);
}

TEST_F(WatchHubTest, EvidenceThatIsCommittedDuringAReadIsCountedOnce) {
  Commit("a", "s", 1);
  Commit("a", "s", 2);
  store_.RunJobs();
  Tick();
  ASSERT_EQ(listener_.posteriors.size(), 1U);
  EXPECT_EQ(listener_.posteriors[0].arms[0].live.window_count, 2U);
}

TEST_F(WatchHubTest, NobodysSceneIsNeitherReadNorTold) {
  Commit("unwatched", "s");
  EXPECT_EQ(store_.submit_count, 0U);
  EXPECT_EQ(Tick(), 0U);
}

TEST_F(WatchHubTest, AResetForgetsTheSumsAndIsTold) {
  Commit("a", "s", 1);
  store_.RunJobs();
  hub_.Reset();
  Tick();
  EXPECT_EQ(listener_.reset_count, 1);
  EXPECT_THAT(listener_.posteriors, IsEmpty());
  Commit("a", "s", 2);
  store_.RunJobs();
  Tick();
  EXPECT_EQ(store_.submit_count, 2U);
  EXPECT_EQ(listener_.posteriors[0].arms[0].live.window_count, 2U);
}

TEST_F(WatchHubTest, AFullStoreIsAskedAgainAtTheNextTick) {
  store_.full = true;
  Commit("a", "s", 1);
  EXPECT_EQ(Tick(), 1U);
  EXPECT_EQ(store_.submit_count, 2U);
  store_.full = false;
  Tick();
  store_.RunJobs();
  Tick();
  EXPECT_EQ(store_.submit_count, 3U);
  EXPECT_EQ(listener_.posteriors.size(), 1U);
  EXPECT_EQ(Tick(), 0U);
}

TEST_F(WatchHubTest, ASceneThatTheDiskCannotReadIsReadAgainAtTheNextTickWithoutEvidence) {
  store_.read_status = absl::UnavailableError("the disk cannot read");
  Commit("a", "s", 1);
  for (int i = 0; i < 3; ++i) {
    store_.RunJobs();
    EXPECT_EQ(Tick(), 1U);
  }
  EXPECT_THAT(listener_.posteriors, IsEmpty());
  store_.read_status = absl::OkStatus();
  store_.RunJobs();
  Tick();
  ASSERT_EQ(listener_.posteriors.size(), 1U);
  EXPECT_EQ(listener_.posteriors[0].arms[0].live.window_count, 1U);
  EXPECT_EQ(Tick(), 0U);
}

TEST_F(WatchHubTest, ADamagedSceneIsReadAgainAtItsNextEvidenceOnly) {
  store_.read_status = absl::DataLossError("damaged");
  Commit("a", "s", 1);
  store_.RunJobs();
  EXPECT_EQ(Tick(), 0U);
  store_.read_status = absl::OkStatus();
  Commit("a", "s", 2);
  store_.RunJobs();
  Tick();
  ASSERT_EQ(listener_.posteriors.size(), 1U);
  EXPECT_EQ(listener_.posteriors[0].arms[0].live.window_count, 2U);
}

TEST_F(WatchHubTest, OfManyScenesThatCouldNotBeReadSomeAreReadAtEachTick) {
  store_.full = true;
  const size_t count = WatchHub::kReadsPerTick + 1;
  for (size_t i = 0; i < count; ++i) Commit(std::to_string(i), "s" + std::to_string(i));
  store_.full = false;
  store_.submit_count = 0;
  Tick();
  EXPECT_EQ(store_.submit_count, WatchHub::kReadsPerTick);
  Tick();
  EXPECT_EQ(store_.submit_count, count);
}

TEST_F(WatchHubTest, WhatNobodyTellsOfIsReadAndTold) {
  Commit("a", "s", 1);
  store_.RunJobs();
  Tick();
  priors::SourceUpdate lost;
  lost.progress.source_id = "lost";
  lost.progress.commit_sequence = 1;
  lost.increments.push_back(
      {{.project = "game", .scene = "a", .measured_by = {}, .arm = "Grid", .machine_class = {}},
       {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 0}});
  store_.Commit(lost, [](const absl::Status&) {});
  hub_.Reload(Scene("a"));
  Commit("a", "s", 2);  // while it is read
  Tick();
  store_.RunJobs();
  Tick();
  const SceneEvidence& last = listener_.posteriors.back();
  EXPECT_EQ(last.source_count, 2U);
  EXPECT_EQ(last.arms[0].live.window_count, 3U);
}

TEST_F(WatchHubTest, ADrainingHubAsksTheStoreForNothing) {
  Commit("a", "s", 1);
  hub_.Drain();
  store_.RunJobs();
  Commit("b", "t", 1);
  EXPECT_EQ(store_.submit_count, 1U);
  EXPECT_EQ(Tick(), 0U);
  EXPECT_THAT(listener_.posteriors, IsEmpty());
}

}  // namespace
}  // namespace sweepstake::watch
