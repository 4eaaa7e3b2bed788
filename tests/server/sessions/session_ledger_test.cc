// Tests the updates that a session's ledger offers to a slow store. Every update contains exactly
// the evidence up to its sequence number.
#include "server/sessions/session_ledger.h"

#include <gtest/gtest.h>

#include <future>

#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::sessions {
namespace {

// Holds offered updates until the test answers.
class LateStore final : public priors::AsyncPriorStore {
 public:
  void Commit(priors::SourceUpdate update, CommitCallback done) override {
    offered.push_back(std::move(update));
    done_ = std::move(done);
  }
  bool Submit(Job /*job*/) override { return false; }
  bool Read(ReadJob /*job*/) override { return false; }
  bool healthy() const override { return true; }
  priors::StoreLosses losses() const override { return {}; }
  void Answer(const absl::Status& status) { std::exchange(done_, nullptr)(status); }

  std::vector<priors::SourceUpdate> offered;

 private:
  CommitCallback done_;
};

class SessionLedgerTest : public ::testing::Test {
 protected:
  void SetUp() override { ledger_->StartAudit({}); }

  void Learn(double alpha, const std::string& row) {
    priors::KeyedEvidence increment;
    increment.key.arm = "Grid";
    increment.evidence.alpha = alpha;
    ledger_->Add(increment);
    ledger_->AddAuditRow(row);
  }
  void Checkpoint(uint64_t sequence) { ledger_->Checkpoint({.message_sequence = sequence}); }
  // Returns when the ledger has received the answer.
  void Answer(const absl::Status& status) {
    store_.Answer(status);
    std::promise<void> done;
    loop_.PostLater([&] { done.set_value(); });
    done.get_future().wait();
  }
  void ExpectOffer(size_t index, uint64_t sequence, double alpha,
                   const std::vector<priors::StoredAuditRow>& rows) {
    ASSERT_EQ(store_.offered.size(), index + 1);
    const priors::SourceUpdate& update = store_.offered[index];
    EXPECT_EQ(update.progress.message_sequence, sequence);
    ASSERT_EQ(update.increments.size(), 1u);
    EXPECT_EQ(update.increments[0].evidence.alpha, alpha);
    EXPECT_EQ(update.audit.rows, rows);
  }

  ManualClock clock_;
  SessionCounters counters_;
  LateStore store_;
  DecisionLoop loop_{clock_};
  std::shared_ptr<SessionLedger> ledger_ = std::make_shared<SessionLedger>(
      store_, loop_, counters_, priors::SourceProgress{.source_id = "session"},
      [](const absl::Status&, std::span<const priors::KeyedEvidence>) {});
};

TEST_F(SessionLedgerTest, EvidenceAfterACheckpointWaitsForTheNextEvenIfACommitEndsInBetween) {
  Learn(1, "first");
  Checkpoint(1);
  ExpectOffer(0, 1, 1, {{1, "first"}});
  Learn(2, "second");
  Checkpoint(2);
  Learn(4, "a bail-out of message 3");
  Answer(absl::OkStatus());
  ExpectOffer(1, 2, 2, {{2, "second"}});
  Answer(absl::OkStatus());
  EXPECT_EQ(ledger_->durable_sequence(), 2u);
  Checkpoint(3);
  ExpectOffer(2, 3, 4, {{3, "a bail-out of message 3"}});
}

TEST_F(SessionLedgerTest, AuditRowsAreStoredWithTheFirstMessageAndNotAlone) {
  ledger_->AddAuditRow("setup");
  Checkpoint(0);
  EXPECT_TRUE(store_.offered.empty());
  EXPECT_TRUE(ledger_->settled());
  Learn(1, "first");
  Checkpoint(1);
  ExpectOffer(0, 1, 1, {{1, "setup"}, {2, "first"}});
  Answer(absl::OkStatus());
  ledger_->AddAuditRow("a tick without messages");
  Checkpoint(1);
  EXPECT_EQ(store_.offered.size(), 2u);
}

TEST_F(SessionLedgerTest, CheckpointsDuringACommitMergeIntoOneUpdate) {
  Learn(1, "first");
  Checkpoint(1);
  Learn(2, "second");
  Checkpoint(2);
  Learn(4, "third");
  Checkpoint(3);
  Answer(absl::OkStatus());
  ExpectOffer(1, 3, 6, {{2, "second"}, {3, "third"}});
}

TEST_F(SessionLedgerTest, AFailedUpdateIsOfferedAgainUnchanged) {
  Learn(1, "first");
  Checkpoint(1);
  Answer(absl::UnavailableError("the disk is full"));
  Learn(2, "second");
  Checkpoint(2);
  ExpectOffer(1, 1, 1, {{1, "first"}});
  EXPECT_EQ(store_.offered[1].progress.commit_sequence, 1u);
  Answer(absl::OkStatus());
  ExpectOffer(2, 2, 2, {{2, "second"}});
}

TEST_F(SessionLedgerTest, EvidenceIsDroppedIfAnotherDaemonContinuesTheSession) {
  Learn(1, "first");
  Checkpoint(1);
  const uint64_t writer = store_.offered[0].writer.id;
  EXPECT_NE(writer, 0u);
  EXPECT_EQ(store_.offered[0].writer.resumed_sequence, 0u);
  Learn(2, "second");
  Checkpoint(2);
  Learn(4, "third");
  Answer(absl::FailedPreconditionError("another daemon continues the session"));
  EXPECT_TRUE(ledger_->superseded());
  EXPECT_TRUE(ledger_->settled());
  EXPECT_FALSE(ledger_->open());
  EXPECT_EQ(ledger_->durable_sequence(), 0u);
  Learn(5, "fourth");
  Checkpoint(3);
  EXPECT_EQ(store_.offered.size(), 1u);
  EXPECT_TRUE(ledger_->settled());
  EXPECT_EQ(counters_.waiting_audit_bytes, 0u);
}

TEST_F(SessionLedgerTest, ALedgerThatStartsFromTheStoreIsAnotherWriter) {
  Learn(1, "first");
  Checkpoint(1);
  Answer(absl::OkStatus());
  ledger_ = std::make_shared<SessionLedger>(
      store_, loop_, counters_,
      priors::SourceProgress{.source_id = "session", .commit_sequence = 1, .message_sequence = 1},
      [](const absl::Status&, std::span<const priors::KeyedEvidence>) {});
  ledger_->StartAudit({});
  Learn(2, "second");
  Checkpoint(2);
  ExpectOffer(1, 2, 2, {{1, "second"}});
  EXPECT_NE(store_.offered[1].writer.id, store_.offered[0].writer.id);
  EXPECT_EQ(store_.offered[1].writer.resumed_sequence, 1u);
}

TEST_F(SessionLedgerTest, AuditRowsWithoutRoomAreLostAndLaterRowsAreKept) {
  const std::string half(kMaxWaitingAuditBytesOfSession / 2, 'x');
  Learn(1, half);
  Checkpoint(1);
  Answer(absl::UnavailableError("the disk is full"));
  Learn(2, half);
  Learn(4, "lost");
  EXPECT_EQ(counters_.lost_audit_row_count, 1u);
  EXPECT_EQ(counters_.waiting_audit_bytes, kMaxWaitingAuditBytesOfSession);
  Checkpoint(2);
  Answer(absl::OkStatus());
  Learn(8, "fourth");
  ExpectOffer(2, 2, 6, {{2, half}});
  Checkpoint(3);
  Answer(absl::OkStatus());
  ExpectOffer(3, 3, 8, {{4, "fourth"}});
  Answer(absl::OkStatus());
  EXPECT_EQ(counters_.waiting_audit_bytes, 0u);
  EXPECT_EQ(counters_.lost_audit_row_count, 1u);
}

TEST_F(SessionLedgerTest, AllSessionsShareOneBudgetForWaitingAuditRows) {
  counters_.waiting_audit_bytes = kMaxWaitingAuditBytes - 3;
  Learn(1, "one");
  Learn(2, "two");
  EXPECT_EQ(counters_.lost_audit_row_count, 1u);
  EXPECT_EQ(counters_.waiting_audit_bytes, kMaxWaitingAuditBytes);
  ledger_.reset();
  EXPECT_EQ(counters_.waiting_audit_bytes, kMaxWaitingAuditBytes - 3)
      << "the destructor returned its bytes";
}

TEST_F(SessionLedgerTest, AuditRowsOfAnUpdateThatCanNeverBeStoredAreCounted) {
  Learn(1, "one");
  Checkpoint(1);
  Answer(absl::InvalidArgumentError("beyond the bounds"));
  EXPECT_EQ(counters_.lost_audit_row_count, 1u);
  EXPECT_EQ(counters_.waiting_audit_bytes, 0u);
}

}  // namespace
}  // namespace sweepstake::sessions
