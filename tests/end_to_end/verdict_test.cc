// Tests the verdict about its scene that a game receives over the real stream: one arm is clearly
// the best, or even the best arm is too slow. diagnosis_test.cc tests a tie, without a stream.
#include <gtest/gtest.h>

#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

class VerdictTest : public testing::Test {
 protected:
  // Runs until the game receives this verdict.
  static SceneVerdict Hear(Verdict verdict, ScriptedGame& game) {
    EXPECT_TRUE(game.RunUntil([verdict](const SessionStats& stats) {
      return stats.verdict.verdict == verdict;
    })) << game.stats().last_error;
    return game.stats().verdict;
  }

  TemporaryDirectory data_;
  DaemonProcess daemon_{data_.path()};
};

TEST_F(VerdictTest, IsStableIfOneArmIsClearlyTheBest) {
  ScriptedGame game(daemon_.address(), FastOptions());
  // The frame thread can read the verdict without the session.
  const auto knows_the_best = [&game](const SessionStats&) {
    const SceneVerdict verdict = game.adaptive().verdict();
    return verdict.verdict == Verdict::kStable && verdict.leader_arm == kScriptedBest;
  };
  EXPECT_TRUE(game.RunUntil(knows_the_best)) << game.stats().last_error;
  EXPECT_GE(game.adaptive().verdict().leader_probability, 0.8);
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
}

TEST_F(VerdictTest, IsDegradedIfEvenTheBestArmMissesTheFrameRate) {
  ScriptedGame game(daemon_.address(), FastOptions(), {400, 250, 60, 300, 200, 350, 80});
  Hear(Verdict::kDegraded, game);
}

}  // namespace
}  // namespace sweepstake::test_support
