#include "engine_client/adaptive/verdict_slot.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

TEST(VerdictSlot, IsUnknownAtFirst) {
  const SceneVerdict verdict = VerdictSlot().Get();
  EXPECT_EQ(verdict.verdict, Verdict::kUnknown);
  EXPECT_EQ(verdict.leader_arm, 0U);
  EXPECT_EQ(verdict.leader_probability, 0);
}

TEST(VerdictSlot, ReturnsTheLatestVerdict) {
  VerdictSlot slot;
  slot.Set({.verdict = Verdict::kDegraded, .leader_arm = 31, .leader_probability = 1});
  slot.Set({.verdict = Verdict::kTie, .leader_arm = 6, .leader_probability = 0.4321});
  const SceneVerdict verdict = slot.Get();
  EXPECT_EQ(verdict.verdict, Verdict::kTie);
  EXPECT_EQ(verdict.leader_arm, 6U);
  EXPECT_NEAR(verdict.leader_probability, 0.4321, 1e-7);
}

}  // namespace
}  // namespace sweepstake
