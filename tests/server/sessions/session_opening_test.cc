// Tests the path from a Hello to a session without a stream: each test runs the loop and the store
// by hand.
#include "server/sessions/session_opening.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/common/reasons.h"
#include "server/sessions/resume_token.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::sessions {
namespace {

// Queues jobs until the test runs them.
class QueuedStore final : public priors::AsyncPriorStore {
 public:
  void Commit(priors::SourceUpdate update, CommitCallback done) override {
    done(store_->Commit({&update, 1}));
  }
  bool Submit(Job job) override {
    if (!full) jobs.emplace_back(std::move(job));
    return !full;
  }
  bool Read(ReadJob job) override {
    reads.emplace_back(std::move(job));
    return true;
  }
  bool healthy() const override { return true; }
  priors::StoreLosses losses() const override { return {}; }
  // RunRead and RunJob return whether there was a job to run.
  bool RunRead() { return Run(reads); }
  bool RunJob() { return Run(jobs); }
  priors::PriorStore& store() { return *store_; }

  bool full = false;
  std::deque<Job> jobs;
  std::deque<ReadJob> reads;

 private:
  template <typename Queue>
  bool Run(Queue& queue) {
    if (queue.empty()) return false;
    const auto job = std::move(queue.front());
    queue.pop_front();
    job(*store_);
    return true;
  }

  const std::unique_ptr<priors::PriorStore> store_ = *storage::OpenMemoryPriorStore();
};

class NoObserver final : public SessionObserver {
 public:
  void OnSession(const std::string&, const SessionChange&) override {}
  bool Watches(const priors::SceneKey&) const override { return false; }
  void OnDecision(const SessionDecision&) override {}
  void OnEvidence(const priors::SceneKey&, std::span<const priors::KeyedEvidence>, bool) override {}
  void Reload(const priors::SceneKey&) override {}
};

SessionRequest HelloOf(const std::string& scene) {
  SessionRequest hello;
  hello.scene = {"game", scene, "", 1};
  hello.arms = {"Grid"};
  hello.backend_versions = {1};
  hello.policy = "paper";
  return hello;
}

class SessionOpeningTest : public ::testing::Test {
 protected:
  SessionOpeningTest() { options_.resume_secret = std::string(32, 's'); }

  std::shared_ptr<SessionOpening> Open(SessionRequest hello, int64_t token_id = 0) {
    opened_.reset();
    hello.origin.token_id = token_id;
    const auto opening = std::make_shared<SessionOpening>(
        table_, std::move(hello),
        [this](absl::StatusOr<OpenedSession> opened) { opened_ = std::move(opened); });
    opening->Run();
    return opening;
  }
  // Opens the session and runs the store's jobs.
  OpenedSession Begin(const SessionRequest& hello) {
    const auto opening = Open(hello);
    store_.RunRead();
    store_.RunJob();
    loop_.RunReady();
    EXPECT_TRUE(opened_ && opened_->ok());
    return **opened_;
  }
  void Store(const std::string& scene) {
    priors::SourceUpdate update;
    update.progress.source_id = "source";
    update.progress.commit_sequence = 1;
    update.increments.push_back({priors::EvidenceKeyOf({"game", scene, "", 1}, "Grid", 1, {}),
                                 {.alpha = 3, .beta = 1, .window_count = 4, .bail_out_count = 0}});
    EXPECT_TRUE(store_.store().Commit({&update, 1}).ok());
  }
  std::string ReasonOfEnd() const { return ReasonNameOf(opened_->status()); }

  HostedSessionOptions options_;
  ManualClock clock_;
  QueuedStore store_;
  SessionCounters counters_;
  NoObserver observer_;
  DecisionLoop loop_{clock_, {}, DecisionLoop::Runner::kCaller};
  SessionTable table_{{options_, loop_, store_, counters_, observer_}};
  std::optional<absl::StatusOr<OpenedSession>> opened_;
};

TEST_F(SessionOpeningTest, AStoredSceneNeedsOneReadAndNoWrite) {
  Store("harbour");
  const auto opening = Open(HelloOf("harbour"));
  EXPECT_TRUE(store_.RunRead());
  EXPECT_FALSE(store_.RunJob());
  loop_.RunReady();
  ASSERT_TRUE(opened_ && opened_->ok());
  EXPECT_EQ((*opened_)->session->prior_source_count(), 1u);
  EXPECT_EQ(table_.size(), 1u);
  EXPECT_EQ(table_.new_scenes().size(), 0u);
}

TEST_F(SessionOpeningTest, ANewSceneIsCountedBeforeTheLoopReceivesTheResult) {
  const auto opening = Open(HelloOf("harbour"));
  EXPECT_TRUE(store_.RunRead());
  loop_.RunReady();
  EXPECT_FALSE(opened_);
  EXPECT_TRUE(store_.RunJob());
  loop_.RunReady();
  ASSERT_TRUE(opened_ && opened_->ok());
  EXPECT_TRUE(store_.reads.empty() && store_.jobs.empty()) << "nothing is read twice";
  EXPECT_EQ(table_.new_scenes().size(), 1u);
}

TEST_F(SessionOpeningTest, ANewSceneIsRefusedIfTheStoreCannotCountIt) {
  const auto opening = Open(HelloOf("harbour"));
  store_.full = true;
  EXPECT_TRUE(store_.RunRead());
  loop_.RunReady();
  ASSERT_TRUE(opened_);
  EXPECT_EQ(ReasonOfEnd(), "STORE_BUSY");
  EXPECT_EQ(table_.size(), 0u);
}

TEST_F(SessionOpeningTest, ASessionBeginsWithoutEvidenceIfTheStoreDoesNotAnswer) {
  Store("harbour");
  const auto opening = Open(HelloOf("harbour"));
  clock_.Advance(options_.load_patience_ns);
  loop_.RunReady();
  ASSERT_TRUE(opened_ && opened_->ok());
  EXPECT_FALSE((*opened_)->session->prior_source_count());
  EXPECT_FALSE((*opened_)->missing.ok());
  EXPECT_TRUE(store_.RunRead());
  loop_.RunReady();
  EXPECT_EQ(table_.size(), 1u) << "a late answer changes nothing";
}

TEST_F(SessionOpeningTest, NoSessionBeginsForAClientThatHasLeft) {
  Open(HelloOf("harbour")).reset();
  EXPECT_TRUE(store_.RunRead());
  EXPECT_FALSE(store_.RunJob());
  loop_.RunReady();
  EXPECT_FALSE(opened_);
  EXPECT_EQ(table_.size(), 0u);
}

TEST_F(SessionOpeningTest, ASessionInMemoryIsResumedWithoutTheStore) {
  const OpenedSession first = Begin(HelloOf("harbour"));
  SessionRequest hello = HelloOf("harbour");
  hello.session_id = first.session->identity().id;
  hello.resume_token = ResumeTokenOf(hello.session_id, 0, options_.resume_secret);
  const auto opening = Open(hello);
  ASSERT_TRUE(opened_ && opened_->ok());
  EXPECT_TRUE((*opened_)->resumed);
  EXPECT_EQ((*opened_)->session, first.session);
}

TEST_F(SessionOpeningTest, ASessionThatEndsWhileTheStoreIsReadIsRefusedOnce) {
  Store("harbour");
  const OpenedSession first = Begin(HelloOf("harbour"));
  priors::SourceUpdate update;
  update.progress.source_id = first.session->identity().id;
  update.progress.commit_sequence = 1;
  update.progress.message_sequence = 1;
  ASSERT_TRUE(store_.store().Commit({&update, 1}).ok());
  table_.Forget(*first.session);
  SessionRequest hello = HelloOf("harbour");
  hello.session_id = first.session->identity().id;
  hello.resume_token = ResumeTokenOf(hello.session_id, 0, options_.resume_secret);
  const auto opening = Open(hello);
  EXPECT_TRUE(store_.RunJob());
  ASSERT_TRUE(table_.Add(first.session).ok());
  first.session->End();
  loop_.RunReady();
  ASSERT_TRUE(opened_);
  EXPECT_EQ(ReasonOfEnd(), "STORE_BUSY");
  const auto again = Open(hello);
  store_.RunRead();
  loop_.RunReady();
  ASSERT_TRUE(opened_ && opened_->ok());
  EXPECT_FALSE((*opened_)->resumed);
}

TEST_F(SessionOpeningTest, ADifferentTokenCannotResumeTheSession) {
  SessionRequest hello = HelloOf("harbour");
  hello.session_id = "session";
  hello.resume_token = ResumeTokenOf("session", 7, options_.resume_secret);
  const auto opening = Open(hello, /*token_id=*/8);
  ASSERT_TRUE(opened_);
  EXPECT_EQ(ReasonOfEnd(), "FOREIGN_SESSION");
}

}  // namespace
}  // namespace sweepstake::sessions
