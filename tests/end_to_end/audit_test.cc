// Tests the audit log of a real game with a real daemon: every decision must be derivable from the
// data on disk, also after the daemon was killed.
#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "engine_client/decider/audit/rederive.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

class AuditTest : public ::testing::TestWithParam<std::string> {
 protected:
  SessionOptions Options() const {
    SessionOptions options = FastOptions();
    options.policy = GetParam();
    return options;
  }
  decision::AuditReport Derived() const {
    decision::AuditReport report = decision::Rederive(ReadAuditLog(data_.path()));
    EXPECT_FALSE(report.difference) << report.difference->Text();
    return report;
  }

  // Runs no faster than the daemon acknowledges, because the queue of audit rows that wait for the
  // disk is bounded.
  static bool RunInStep(ScriptedGame& game, const std::function<bool(const SessionStats&)>& done) {
    constexpr uint64_t kMessagesAhead = 8;
    return game.RunUntil([&](const SessionStats& stats) {
      while (game.stats().acknowledged_sequence + kMessagesAhead < stats.sent_sequence)
        std::this_thread::yield();
      return done(game.stats());
    });
  }

  const TemporaryDirectory data_;
};

TEST_P(AuditTest, EveryDecisionOfAKilledDaemonCanBeReplayed) {
  auto daemon = std::make_unique<DaemonProcess>(data_.path());
  const std::string address = daemon->address();
  ScriptedGame game(address, Options());
  uint64_t decision_count = 0;
  for (uint64_t kills = 0; kills < 3; ++kills) {
    const uint64_t acknowledged = game.stats().acknowledged_sequence;
    ASSERT_TRUE(RunInStep(game, [&](const SessionStats& stats) {
      return stats.connection_count == kills + 1 &&
             stats.acknowledged_sequence >= acknowledged + 40;
    })) << game.stats().last_error;
    daemon->Kill();
    const decision::AuditReport report = Derived();
    EXPECT_EQ(report.session_count, 1U);
    EXPECT_EQ(report.segment_count, kills + 1);
    EXPECT_GT(report.decision_count, decision_count);
    decision_count = report.decision_count;
    daemon = std::make_unique<DaemonProcess>(data_.path(), address);
  }
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 4; }));
  game.Stop();
  EXPECT_EQ(daemon->Terminate(), 0);
  EXPECT_EQ(Derived().segment_count, 4U);
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
}

TEST_P(AuditTest, ContainsEveryDecisionOfASessionThatSaidGoodbye) {
  DaemonProcess daemon(data_.path());
  ScriptedGame game(daemon.address(), Options());
  ASSERT_TRUE(RunInStep(game, [](const SessionStats& stats) {
    return LearntEvidence(stats) >= 100;
  })) << game.stats().last_error;
  game.Stop();
  EXPECT_EQ(daemon.Terminate(), 0);
  const uint64_t taken = ReadSource(data_.path(), game.stats().session_id).progress.decision_count;
  EXPECT_EQ(Derived().decision_count, taken);
}

INSTANTIATE_TEST_SUITE_P(Policies, AuditTest, ::testing::Values("paper", "adaptive"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace sweepstake::test_support
