// Tests games and their evidence while the daemon is absent, killed or stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/end_to_end/scripted_game.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::Ge;
using ::testing::Gt;
using ::testing::HasSubstr;

TEST(RestartTest, AKilledDaemonLosesNothingAcknowledgedAndCountsNothingTwice) {
  const TemporaryDirectory data;
  auto daemon = std::make_unique<DaemonProcess>(data.path());
  const std::string address = daemon->address();
  ScriptedGame game(address, FastOptions());

  priors::SourceProgress before;
  for (uint64_t kills = 0; kills < 5; ++kills) {
    const uint64_t acknowledged = game.stats().acknowledged_sequence;
    ASSERT_TRUE(game.RunUntil([&](const SessionStats& stats) {
      return stats.connection_count == kills + 1 &&
             stats.acknowledged_sequence >= acknowledged + 40;
    })) << game.stats().last_error;
    game.BailOut();
    game.RunFrames(100);
    daemon->Pause();  // so that messages are in progress at the kill
    game.BailOut();
    ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) {
      return stats.sent_sequence >= stats.acknowledged_sequence + 5;
    }));
    const SessionStats at_kill = game.stats();
    daemon->Kill();
    const priors::SourceState source = ReadSource(data.path(), at_kill.session_id);
    EXPECT_THAT(source.progress.message_sequence, Ge(at_kill.acknowledged_sequence));
    EXPECT_THAT(source.progress.commit_sequence, Gt(before.commit_sequence));
    ExpectConsistent(source);
    before = source.progress;
    game.RunFrames(2'000);  // The frames continue without a daemon.
    game.BailOut();
    daemon = std::make_unique<DaemonProcess>(data.path(), address);
  }

  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 6; }));
  game.Stop();
  const SessionStats stats = game.stats();
  EXPECT_EQ(stats.resumed_count, 5U);
  EXPECT_THAT(stats.resent_message_count, Gt(0U));
  EXPECT_EQ(stats.acknowledged_sequence, stats.sent_sequence)
      << "goodbye waits for the disk: " << stats.last_error;
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
  EXPECT_EQ(daemon->Terminate(), 0);

  const priors::SourceState source = ReadSource(data.path(), stats.session_id);
  EXPECT_EQ(source.progress.message_sequence, stats.sent_sequence);
  EXPECT_EQ(source.progress.frame_count, stats.sent_frame_count)
      << "every frame that was sent is in the store, once";
  EXPECT_EQ(stats.dropped_frame_count, 0U);
  EXPECT_EQ(TotalEvidence(source).bail_out_count, 15U) << "three in each of five rounds";
  ExpectConsistent(source);
}

TEST(RestartTest, AHangingDaemonCostsSamplesButNoFrames) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  SessionOptions options = FastOptions();
  options.queue_frames = 1024;
  ScriptedGame game(daemon.address(), options);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 10; }));
  daemon.Pause();
  // The connection accepts some messages before the queue fills. Unlike RunUntil, this does not
  // wait for the sender.
  for (int round = 0; round < 100 && game.stats().dropped_frame_count == 0; ++round)
    game.RunFrames(100'000);
  EXPECT_THAT(game.stats().dropped_frame_count, Gt(0U)) << "a full queue drops its oldest";
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
  game.Stop(100);
}

TEST(RestartTest, AGameConnectsToADaemonThatStartsLater) {
  const TemporaryDirectory data;
  std::string address;
  {
    const DaemonProcess first(data.path());  // only to find a free port
    address = first.address();
  }
  ScriptedGame game(address, FastOptions());
  game.RunFrames(20'000);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return !stats.last_error.empty(); }));
  EXPECT_THAT(game.stats().last_error, HasSubstr(address));
  const DaemonProcess daemon(data.path(), address);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 5; }));
  EXPECT_EQ(game.wait_count(), 0U);
}

TEST(RestartTest, ADaemonWithAnotherPolicyStartsANewSessionThatLearns) {
  const TemporaryDirectory data;
  auto daemon = std::make_unique<DaemonProcess>(
      data.path(), "127.0.0.1:0", std::vector<std::string>{"--decision-policy", "paper"});
  const std::string address = daemon->address();
  SessionOptions options = FastOptions();
  options.policy.clear();  // uses the daemon's default
  ScriptedGame game(address, options);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 10; }));
  const std::string first = game.stats().session_id;
  EXPECT_EQ(daemon->Terminate(), 0);
  daemon = std::make_unique<DaemonProcess>(
      data.path(), address, std::vector<std::string>{"--decision-policy", "adaptive"});
  // The smallest evidence of the new session, from its start.
  double least = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(game.RunUntil([&](const SessionStats& stats) {
    if (stats.session_id == first || stats.beliefs.empty()) return false;
    least = std::min(least, LearntEvidence(stats));
    return LearntEvidence(stats) >= least + 3;
  })) << game.stats().last_error;
  EXPECT_EQ(game.stats().resumed_count, 0U);
  game.Stop();
  const SessionStats stats = game.stats();
  EXPECT_EQ(stats.acknowledged_sequence, stats.sent_sequence);
  EXPECT_EQ(daemon->Terminate(), 0);
  EXPECT_THAT(TotalEvidence(ReadSource(data.path(), stats.session_id)).window_count, Gt(0U));
}

TEST(RestartTest, ADrainedDaemonEndsCleanlyAndTheSessionContinuesWithTheNext) {
  const TemporaryDirectory data;
  auto daemon = std::make_unique<DaemonProcess>(data.path());
  const std::string address = daemon->address();
  ScriptedGame game(address, FastOptions());
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 10; }));
  EXPECT_EQ(daemon->Terminate(), 0);
  daemon = std::make_unique<DaemonProcess>(data.path(), address);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.resumed_count == 1; }))
      << game.stats().last_error;
  game.Stop();
  EXPECT_EQ(daemon->Terminate(), 0);
  ExpectConsistent(ReadSource(data.path(), game.stats().session_id));
}

}  // namespace
}  // namespace sweepstake::test_support
