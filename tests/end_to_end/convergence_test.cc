// Tests the whole system over the real stream: a daemon process and a game with scripted arm costs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::Gt;
using ::testing::Lt;

uint32_t HighestMean(const SessionStats& stats) {
  const auto mean = [](const ArmBelief& belief) {
    return belief.alpha / (belief.alpha + belief.beta);
  };
  const auto best =
      std::max_element(stats.beliefs.begin(), stats.beliefs.end(),
                       [&](const auto& a, const auto& b) { return mean(a) < mean(b); });
  return static_cast<uint32_t>(best - stats.beliefs.begin());
}

TEST(ConvergenceTest, LearnsTheBestArmAndRunsItMost) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  ScriptedGame game(daemon.address(), FastOptions());

  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 240; }))
      << game.stats().last_error;

  const SessionStats stats = game.stats();
  EXPECT_EQ(HighestMean(stats), kScriptedBest);
  std::vector<double> evidence;  // by arm; grows by one for each window in which the arm was active
  for (const ArmBelief& belief : stats.beliefs) evidence.push_back(belief.alpha + belief.beta);
  EXPECT_EQ(std::max_element(evidence.begin(), evidence.end()) - evidence.begin(), kScriptedBest);
  EXPECT_THAT(stats.command_count, Gt(6U)) << "the exploration commands every other arm once";
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
  game.Stop();
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST(ConvergenceTest, TheSecondRunStartsFromThePriorsOfTheFirst) {
  const TemporaryDirectory data;
  const auto enough = [](const SessionStats& stats) { return LearntEvidence(stats) >= 60; };
  {
    DaemonProcess daemon(data.path());
    ScriptedGame game(daemon.address(), FastOptions());
    ASSERT_TRUE(game.RunUntil(enough)) << game.stats().last_error;
    EXPECT_EQ(game.stats().prior_source_count, 0U);
    game.Stop();
    EXPECT_EQ(daemon.Terminate(), 0);
  }
  DaemonProcess daemon(data.path());
  ScriptedGame game(daemon.address(), FastOptions());
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return !stats.beliefs.empty(); }));
  EXPECT_EQ(game.stats().prior_source_count, 1U);
  EXPECT_THAT(LearntEvidence(game.stats()), Gt(50));
  EXPECT_EQ(HighestMean(game.stats()), kScriptedBest);
}

TEST(ConvergenceTest, IgnoringPriorsStartsFlat) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  {
    ScriptedGame game(daemon.address(), FastOptions());
    ASSERT_TRUE(
        game.RunUntil([](const SessionStats& stats) { return LearntEvidence(stats) >= 30; }));
    game.Stop();
  }
  SessionOptions options = FastOptions();
  options.ignore_priors = true;
  ScriptedGame game(daemon.address(), options);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return !stats.beliefs.empty(); }));
  EXPECT_EQ(game.stats().prior_source_count, 0U);
  EXPECT_THAT(LearntEvidence(game.stats()), Lt(20));
}

}  // namespace
}  // namespace sweepstake::test_support
