// Tests the bus with a store in memory, on a loop that the test runs.
#include "server/events/event_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/sessions/manual_clock.h"
#include "tests/server/storage/forwarding_store.h"

namespace sweepstake::events {
namespace {

using priors::SceneEvidence;
using priors::SceneKey;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

SceneKey Scene(const std::string& name) { return {"game", name, "", 1}; }

// Queues jobs and reads until the test runs them.
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
  bool Read(ReadJob job) override {
    ++read_count;
    if (!full) reads_.push_back(std::move(job));
    return !full;
  }
  bool healthy() const override { return true; }
  priors::StoreLosses losses() const override { return {}; }
  void RunJobs() {
    for (; !jobs_.empty(); jobs_.pop_front()) jobs_.front()(store_);
  }
  void RunReads() {
    for (; !reads_.empty(); reads_.pop_front()) reads_.front()(store_);
  }
  SceneEvidence Load(const SceneKey& key) { return **store_.LoadScene(key); }
  void Revoke(const std::string& source_id) {
    ASSERT_TRUE(store_.Revoke({.id = source_id}, false).ok());
  }

  size_t submit_count = 0;
  size_t read_count = 0;
  bool full = false;
  absl::Status read_status;

 private:
  // Fails to read a scene if the test has set `read_status` to an error.
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
  std::deque<ReadJob> reads_;
};

// Encodes a scene as its index in `scenes`, and a decision as a text of `decision_bytes`.
class RecordingEncoder final : public Encoder {
 public:
  std::string Scene(const SceneEvidence& scene) const override {
    scenes.push_back(scene);
    return std::to_string(scenes.size() - 1);
  }
  std::string Activity(const sessions::SceneActivity& /*activity*/) const override { return ""; }
  std::string Decision(const sessions::SessionDecision& /*decision*/) const override {
    return std::string(decision_bytes, 'd');
  }
  std::string Session(const sessions::SessionView& /*session*/) const override { return ""; }
  std::string SessionEnd(const std::string& id, sessions::SessionEnd /*end*/) const override {
    return id;
  }
  std::string Boxes(const std::string& /*view*/) const override { return ""; }
  std::string Stamp(Kind /*kind*/, const EventStamp& /*stamp*/) const override { return ""; }

  mutable std::deque<SceneEvidence> scenes;
  size_t decision_bytes = 10;
};

// Receives events at once, unless `slow` is set.
class RecordingSink final : public Sink {
 public:
  explicit RecordingSink(const RecordingEncoder& encoder) : encoder_(encoder) {}

  void Begin(std::unique_ptr<Subscriber> begun) override { subscriber = std::move(begun); }
  void Wake() override {
    if (!slow) TakeAll();
  }
  void OnEnd(const absl::Status& status) override {
    end = status;
    subscriber.reset();
  }
  void TakeAll() {
    while (Take()) {
    }
  }
  bool Take() {
    const auto events = subscriber->Take(1);
    if (events.empty()) return false;
    const std::string& body = *events.front()->body;
    if (body.starts_with('d')) {
      names.push_back("decisions");
      decision_bytes += body.size();
    } else if (body.starts_with("session")) {
      names.push_back(body);
    } else {
      posteriors.push_back(encoder_.scenes.at(std::stoul(body)));
      names.push_back(posteriors.back().key.scene);
    }
    return true;
  }

  bool slow = false;
  std::unique_ptr<Subscriber> subscriber;
  std::vector<SceneEvidence> posteriors;
  std::vector<std::string> names;  // names of the received events, in order
  size_t decision_bytes = 0;
  std::optional<absl::Status> end;

 private:
  const RecordingEncoder& encoder_;
};

class EventBusTest : public ::testing::Test {
 protected:
  // Subscribes to all scenes of the project.
  void SetUp() override { Watch(sink_); }
  ~EventBusTest() override {
    for (RecordingSink* sink : {&sink_, &other_}) sink->subscriber.reset();
  }

  void Watch(RecordingSink& sink, Wish wish = {}) {
    wish.filter.project = "game";
    bus_.Subscribe(std::move(wish), sink);
    RunReads();
  }
  // Runs the jobs of the store, and then the tasks that they posted to the loop.
  void RunJobs() {
    store_.RunJobs();
    loop_.RunReady();
  }
  // Repeats, because a read may lead to further reads.
  void RunReads() {
    for (size_t count = 0; std::exchange(count, store_.read_count) != store_.read_count;) {
      store_.RunReads();
      loop_.RunReady();
    }
  }
  // Commits evidence of a session: a live window of one arm, and a lane visit of KDTree. Then
  // notifies the bus.
  void Commit(const std::string& scene, const std::string& source, uint64_t n = 1,
              const std::string& arm = "Grid", const std::string& project = "game") {
    priors::SourceUpdate update;
    update.progress.source_id = source;
    update.progress.commit_sequence = n;
    update.increments.push_back(
        {{.project = project, .scene = scene, .measured_by = {}, .arm = arm, .machine_class = {}},
         {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 0}});
    update.increments.push_back(update.increments.back());
    update.increments.back().key.arm = "KDTree";
    update.increments.back().key.measured_by = "lane";
    store_.Commit(update, [](const absl::Status& status) { ASSERT_TRUE(status.ok()); });
    bus_.OnEvidence({project, scene, "", 1}, update.increments, /*new_source=*/n == 1);
  }
  void Decide(const std::string& scene) {
    const decision::DecisionRecord record;
    sessions::SessionIdentity session;
    session.scene = Scene(scene);
    bus_.OnDecision({.session = session, .record = record});
  }
  // Advances the clock by one tick and runs the loop. Returns whether a tick was due.
  bool Tick() {
    const bool due = loop_.RunReady() != sessions::LoopClock::kNever;
    clock_.Advance(EventBus::kIntervalNs);
    loop_.RunReady();
    return due;
  }

  ManualStore store_;
  sessions::ManualClock clock_;
  sessions::DecisionLoop loop_{clock_, {}, sessions::DecisionLoop::Runner::kCaller};
  RecordingEncoder encoder_;
  sessions::HostedSessionOptions options_;
  sessions::SessionCounters counters_;
  EventBus bus_{store_, loop_, sessions_, encoder_};
  sessions::SessionTable sessions_{{options_, loop_, store_, counters_, bus_}};
  RecordingSink sink_{encoder_};
  RecordingSink other_{encoder_};
};

TEST_F(EventBusTest, AThousandCommitsReadEachSceneOnceAndAddUpToTheStore) {
  for (uint64_t n = 1; n <= 1000; ++n) {
    const std::string scene = std::to_string(n % 4);
    Commit(scene, scene + " " + std::to_string(n % 8), (n + 7) / 8, n % 3 == 0 ? "SAP" : "Grid");
    if (n % 100 == 0) RunJobs();
    if (n % 100 == 50) Tick();
  }
  Tick();
  EXPECT_EQ(store_.submit_count, 4U);
  for (auto last = sink_.posteriors.end() - 4; last != sink_.posteriors.end(); ++last) {
    const SceneEvidence stored = store_.Load(last->key);
    EXPECT_EQ(last->source_count, stored.source_count);
    ASSERT_EQ(last->arms.size(), stored.arms.size());
    for (size_t i = 0; i < stored.arms.size(); ++i) {
      EXPECT_EQ(last->arms[i].name, stored.arms[i].name);
      EXPECT_EQ(last->arms[i].live, stored.arms[i].live);
      EXPECT_EQ(last->arms[i].lane, stored.arms[i].lane);
      EXPECT_GT(last->arms[i].last_seen_unix_s, 0u) << "the time of the commit";
    }
  }
}

TEST_F(EventBusTest, ASceneIsPublishedOncePerTickAndNothingRunsWhileNothingChanges) {
  for (uint64_t n = 1; n <= 20; ++n) {
    Commit("a", "s", n);
    Commit("b", "t", n);
    RunJobs();
  }
  EXPECT_THAT(sink_.posteriors, IsEmpty());
  EXPECT_TRUE(Tick());
  EXPECT_EQ(sink_.posteriors.size(), 2U);
  EXPECT_FALSE(Tick());
  Commit("b", "t", 21);
  EXPECT_TRUE(Tick());
  ASSERT_EQ(sink_.posteriors.size(), 3U);
  EXPECT_EQ(sink_.posteriors[2].key.scene, "b");
  EXPECT_EQ(sink_.posteriors[2].arms[0].live.window_count, 21U);
}

TEST_F(EventBusTest, DecisionsAreSentAtTheNextTickInOneMessageForEachScene) {
  Decide("a");
  Decide("a");
  Decide("b");
  EXPECT_THAT(sink_.names, IsEmpty());
  EXPECT_TRUE(Tick());
  EXPECT_THAT(sink_.names, ElementsAre("decisions", "decisions"));
  EXPECT_EQ(sink_.decision_bytes, 30U);
  EXPECT_FALSE(Tick());
}

TEST_F(EventBusTest, EvidenceThatIsCommittedDuringAReadIsCountedOnce) {
  Commit("a", "s", 1);
  Commit("a", "s", 2);
  RunJobs();
  Tick();
  ASSERT_EQ(sink_.posteriors.size(), 1U);
  EXPECT_EQ(sink_.posteriors[0].arms[0].live.window_count, 2U);
}

TEST_F(EventBusTest, ASceneWithoutAWatcherIsNeitherReadNorPublished) {
  Commit("a", "s", 1, "Grid", "theirs");
  EXPECT_EQ(store_.submit_count, 0U);
  EXPECT_FALSE(Tick());
}

TEST_F(EventBusTest, AResetForgetsTheSumsAndPublishesEveryScene) {
  Commit("a", "s", 1);
  Commit("b", "t", 1);
  RunJobs();
  Tick();
  sink_.names.clear();
  bus_.Reset();
  RunReads();
  EXPECT_THAT(sink_.names, ElementsAre("a", "b"));
  Commit("a", "s", 2);
  RunJobs();
  Tick();
  EXPECT_EQ(store_.submit_count, 3U);
  EXPECT_EQ(sink_.posteriors.back().arms[0].live.window_count, 2U);
}

TEST_F(EventBusTest, AResetSendsEachRevokedSceneWithoutArmsAfterTheState) {
  Commit("a", "s", 1);
  Commit("b", "t", 1);
  Commit("c", "u", 1);
  RunJobs();
  Tick();
  sink_.slow = true;
  store_.Revoke("s");
  bus_.Reset();
  RunReads();
  EXPECT_TRUE(sink_.Take());
  store_.Revoke("t");
  bus_.Reset();  // before the watcher has received the first revocation
  RunReads();
  sink_.names.clear();
  sink_.TakeAll();
  EXPECT_THAT(sink_.names, ElementsAre("c", "a", "b"));
  const size_t count = sink_.posteriors.size();
  EXPECT_THAT(sink_.posteriors[count - 3].arms, Not(IsEmpty()));
  EXPECT_THAT(sink_.posteriors[count - 2].arms, IsEmpty());
  EXPECT_THAT(sink_.posteriors[count - 1].arms, IsEmpty());
  Commit("a", "v", 1);
  RunJobs();
  Tick();
  sink_.TakeAll();
  EXPECT_THAT(sink_.names, ElementsAre("c", "a", "b", "a"));
  EXPECT_THAT(sink_.posteriors.back().arms, Not(IsEmpty()));
}

TEST_F(EventBusTest, ASceneThatAnotherDaemonRevokedIsSentWithoutArms) {
  Commit("a", "s", 1);
  Commit("b", "t", 1);
  RunJobs();
  Tick();
  sink_.names.clear();
  store_.Revoke("s");
  bus_.Reload(Scene("a"));
  RunJobs();
  RunReads();
  sink_.TakeAll();
  EXPECT_THAT(sink_.names, ElementsAre("b", "a"));
  EXPECT_THAT(sink_.posteriors.back().arms, IsEmpty());
}

TEST_F(EventBusTest, ALaterWatcherHasTheStateWithoutTheStore) {
  sink_.subscriber.reset();
  for (size_t i = 0; i < 2 * EventBus::kPageSize; ++i)
    Commit(std::to_string(i), "s" + std::to_string(i));
  Watch(sink_);
  EXPECT_THAT(sink_.posteriors, SizeIs(2 * EventBus::kPageSize));
  const size_t reads = store_.read_count;
  const size_t encoded = encoder_.scenes.size();
  Watch(other_);
  EXPECT_EQ(other_.names, sink_.names);
  EXPECT_EQ(store_.read_count, reads);
  EXPECT_EQ(encoder_.scenes.size(), encoded);
}

TEST_F(EventBusTest, ASlowWatcherHasEachSceneOnceInItsLatestState) {
  Commit("a", "s", 1);
  Commit("b", "t", 1);
  Commit("c", "u", 1);
  RunJobs();
  Tick();
  other_.slow = true;
  Watch(other_);
  EXPECT_TRUE(other_.Take());
  for (uint64_t n = 2; n <= 5; ++n) {
    Commit("a", "s", n);  // the slow watcher has received "a" before
    Commit("c", "u", n);  // it has not received "c" yet
    Tick();
  }
  Decide("a");
  Tick();
  other_.TakeAll();
  EXPECT_THAT(other_.names, ElementsAre("a", "b", "c", "a", "decisions"));
  EXPECT_EQ(other_.posteriors[2].arms[0].live.window_count, 5U);
  EXPECT_EQ(other_.posteriors[3].arms[0].live.window_count, 5U);
}

TEST_F(EventBusTest, ASlowWatcherMissesDecisionsButNoScene) {
  sink_.slow = true;
  Commit("a", "s", 1);
  RunJobs();
  Tick();
  encoder_.decision_bytes = Subscriber::kQueueBytes / 4 + 1;
  for (int i = 0; i < 5; ++i) {
    Decide("a");
    Tick();
  }
  sink_.TakeAll();
  EXPECT_THAT(sink_.names, ElementsAre("a", "decisions", "decisions"));
}

TEST_F(EventBusTest, ASnapshotIsTheStateOnceItIsComplete) {
  sink_.subscriber.reset();
  Commit("a", "s", 1);
  Commit("b", "t", 1);
  sink_.slow = true;
  bus_.Subscribe({.filter = {.project = "game", .scene = ""}, .snapshots = true}, sink_);
  EXPECT_FALSE(sink_.subscriber->TakeSnapshot());
  RunReads();
  EXPECT_FALSE(sink_.Take()) << "the state is in the snapshot";
  EXPECT_THAT(sink_.subscriber->TakeSnapshot()->events, SizeIs(2));
  Commit("b", "t", 2);
  RunJobs();
  Tick();
  sink_.TakeAll();
  EXPECT_THAT(sink_.names, ElementsAre("b"));
  EXPECT_THAT(sink_.subscriber->TakeSnapshot()->events, SizeIs(2));
}

TEST_F(EventBusTest, AResetGivesASubscriberOfSnapshotsANewSnapshotWithoutRevokedScenes) {
  sink_.subscriber.reset();
  Commit("a", "s", 1);
  Watch(sink_, {.snapshots = true});
  EXPECT_THAT(sink_.subscriber->TakeSnapshot()->events, SizeIs(1));
  EXPECT_FALSE(sink_.subscriber->needs_snapshot());
  store_.Revoke("s");
  bus_.Reset();
  EXPECT_TRUE(sink_.subscriber->needs_snapshot());
  EXPECT_FALSE(sink_.subscriber->TakeSnapshot()) << "the state is being read";
  RunReads();
  EXPECT_THAT(sink_.names, IsEmpty()) << "the state is in the snapshot only";
  const auto snapshot = sink_.subscriber->TakeSnapshot();
  ASSERT_TRUE(snapshot);
  EXPECT_THAT(snapshot->events, IsEmpty());
  EXPECT_TRUE(snapshot->replaces_all);
  EXPECT_FALSE(sink_.subscriber->needs_snapshot());
  EXPECT_FALSE(sink_.subscriber->TakeSnapshot()->replaces_all);
}

TEST_F(EventBusTest, TheEndOfASessionIsSentAndItIsNotInTheStateAnyMore) {
  Watch(other_, {.kind = Kind::kSessions});
  bus_.OnSession("session 1", {.scene = Scene("a"), .end = sessions::SessionEnd::kGoodbye});
  Tick();
  EXPECT_THAT(other_.names, ElementsAre("session 1"));
  other_.subscriber.reset();
  other_.names.clear();
  Watch(other_, {.kind = Kind::kSessions});
  EXPECT_THAT(other_.names, IsEmpty());
}

TEST_F(EventBusTest, AStoreThatIsTooBusyEndsTheWatch) {
  store_.full = true;
  Watch(other_, {.kind = Kind::kPosteriors, .filter = {.project = "", .scene = "a"}});
  ASSERT_TRUE(other_.end);
  EXPECT_TRUE(absl::IsUnavailable(*other_.end));
  EXPECT_FALSE(sink_.end);
}

TEST_F(EventBusTest, AWatcherThatMayNotWatchAnyMoreIsEnded) {
  absl::Status still;
  Watch(other_, {.check = [&] { return still; }});
  bus_.EndRefused();
  EXPECT_FALSE(other_.end);
  still = absl::UnauthenticatedError("revoked");
  bus_.EndRefused();
  EXPECT_EQ(other_.end, still);
  EXPECT_FALSE(sink_.end);
}

TEST_F(EventBusTest, AFullStoreIsReadAtTheNextTick) {
  store_.full = true;
  Commit("a", "s", 1);
  EXPECT_TRUE(Tick());
  EXPECT_EQ(store_.submit_count, 2U);
  store_.full = false;
  Tick();
  RunJobs();
  Tick();
  EXPECT_EQ(store_.submit_count, 3U);
  EXPECT_EQ(sink_.posteriors.size(), 1U);
  EXPECT_FALSE(Tick());
}

TEST_F(EventBusTest, ASceneThatTheDiskCannotReadIsReadAgainAtTheNextTickWithoutEvidence) {
  store_.read_status = absl::UnavailableError("the disk cannot read");
  Commit("a", "s", 1);
  for (int i = 0; i < 3; ++i) {
    RunJobs();
    EXPECT_TRUE(Tick());
  }
  EXPECT_THAT(sink_.posteriors, IsEmpty());
  store_.read_status = absl::OkStatus();
  RunJobs();
  Tick();
  ASSERT_EQ(sink_.posteriors.size(), 1U);
  EXPECT_EQ(sink_.posteriors[0].arms[0].live.window_count, 1U);
  EXPECT_FALSE(Tick());
}

TEST_F(EventBusTest, ADamagedSceneIsReadAgainAtItsNextEvidenceOnly) {
  store_.read_status = absl::DataLossError("damaged");
  Commit("a", "s", 1);
  RunJobs();
  EXPECT_FALSE(Tick());
  store_.read_status = absl::OkStatus();
  Commit("a", "s", 2);
  RunJobs();
  Tick();
  ASSERT_EQ(sink_.posteriors.size(), 1U);
  EXPECT_EQ(sink_.posteriors[0].arms[0].live.window_count, 2U);
}

TEST_F(EventBusTest, SomeOfTheScenesThatCouldNotBeReadAreReadAtEachTick) {
  store_.full = true;
  const size_t count = EventBus::kReadsPerTick + 1;
  for (size_t i = 0; i < count; ++i) Commit(std::to_string(i), "s" + std::to_string(i));
  store_.full = false;
  store_.submit_count = 0;
  Tick();
  EXPECT_EQ(store_.submit_count, EventBus::kReadsPerTick);
  Tick();
  EXPECT_EQ(store_.submit_count, count);
}

TEST_F(EventBusTest, AChangeThatIsReportedByNameOnlyIsReadAndPublished) {
  Commit("a", "s", 1);
  RunJobs();
  Tick();
  priors::SourceUpdate lost;
  lost.progress.source_id = "lost";
  lost.progress.commit_sequence = 1;
  lost.increments.push_back(
      {{.project = "game", .scene = "a", .measured_by = {}, .arm = "Grid", .machine_class = {}},
       {.alpha = 0.75, .beta = 0.25, .window_count = 1, .bail_out_count = 0}});
  store_.Commit(lost, [](const absl::Status&) {});
  bus_.Reload(Scene("a"));
  Commit("a", "s", 2);  // while the scene is read
  Tick();
  RunJobs();
  Tick();
  const SceneEvidence& last = sink_.posteriors.back();
  EXPECT_EQ(last.source_count, 2U);
  EXPECT_EQ(last.arms[0].live.window_count, 3U);
}

TEST_F(EventBusTest, ASceneThatIsBeingReadIsPublishedAlsoIfThereAreTooManyScenes) {
  Commit("a", "s", 1);
  RunJobs();
  Tick();
  sink_.names.clear();
  bus_.Reload(Scene("a"));
  for (size_t i = 0; i < EventBus::kMaxScenes; ++i) bus_.Reload(Scene(std::to_string(i)));
  Decide("a");
  EXPECT_TRUE(Tick()) << "it drops the sums of some scenes";
  RunJobs();
  Tick();
  EXPECT_THAT(sink_.names, ElementsAre("decisions", "a"));
}

TEST_F(EventBusTest, ADrainEndsTheWatchesAndReadsTheStoreNoMore) {
  Commit("a", "s", 1);
  bus_.Drain();
  RunJobs();
  Commit("b", "t", 1);
  EXPECT_EQ(store_.submit_count, 1U);
  EXPECT_FALSE(Tick());
  EXPECT_THAT(sink_.posteriors, IsEmpty());
  ASSERT_TRUE(sink_.end);
  EXPECT_TRUE(absl::IsUnavailable(*sink_.end));
  Watch(other_);
  EXPECT_EQ(other_.end, sink_.end);
}

}  // namespace
}  // namespace sweepstake::events
