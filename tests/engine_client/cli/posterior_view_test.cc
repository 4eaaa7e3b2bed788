#include "engine_client/cli/posterior_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

v1::ScenePosterior SomeScene() {
  v1::ScenePosterior scene;
  scene.set_project("game");
  scene.set_scene("arena");
  scene.set_source_count(3);
  v1::ArmPosterior& arm = *scene.add_arms();
  arm.set_arm("SAP");
  arm.set_backend_version(2);
  arm.mutable_posterior()->set_alpha(30);
  arm.mutable_posterior()->set_beta(10);
  arm.set_window_count(38);
  return scene;
}

TEST(ApproximateInterval, IsNearTheExactQuantilesOfAWellObservedArm) {
  // Beta(30, 10): the exact 2.5 % and 97.5 % quantiles are 0.606 and 0.870.
  const Interval interval = ApproximateInterval(30, 10);
  EXPECT_NEAR(interval.low, 0.606, 0.015);
  EXPECT_NEAR(interval.high, 0.870, 0.015);
}

TEST(ApproximateInterval, StaysWithinZeroAndOne) {
  const Interval unknown = ApproximateInterval(1, 1);
  EXPECT_EQ(unknown.low, 0);
  EXPECT_EQ(unknown.high, 1);
}

TEST(ApproximateInterval, IsEverythingWithoutEvidence) {
  const Interval nothing = ApproximateInterval(0, 0);
  EXPECT_EQ(nothing.low, 0);
  EXPECT_EQ(nothing.high, 1);
}

TEST(IntervalBar, MarksTheMeanWithinTheInterval) {
  EXPECT_EQ(IntervalBar(0.5, {0.25, 0.75}, 8), "  --|-- ");
  EXPECT_EQ(IntervalBar(1, {1, 1}, 4), "   |");
  EXPECT_EQ(IntervalBar(0, {0, 0}, 4), "|   ");
}

TEST(PosteriorText, NamesTheSceneItsSourcesAndEachArm) {
  const std::string text = PosteriorText(SomeScene());
  EXPECT_THAT(text, HasSubstr("game / arena: 0 sessions now, evidence of 3 in all\n"));
  EXPECT_THAT(text, HasSubstr("SAP"));
  EXPECT_THAT(text, HasSubstr("0.750"));
}

TEST(PosteriorJson, HoldsTheNumbersOfEachArm) {
  const auto document = PosteriorJson(SomeScene());
  EXPECT_EQ(document["arms"][0]["alpha"], 30);
  EXPECT_EQ(document["arms"][0]["n"], 40);
  EXPECT_EQ(document["sources"], 3);
}

TEST(DecisionText, SaysWhatBecameOfTheCandidate) {
  v1::DecisionEvent event;
  event.set_scene("arena");
  event.set_decision_id(7);
  event.set_active_arm("SAP");
  event.set_candidate_arm("KDTree");
  event.set_outcome(v1::DECISION_OUTCOME_SWITCHED);
  event.set_reason(v1::SWITCH_REASON_BAIL_OUT);
  event.set_reward(0.7312);
  EXPECT_EQ(DecisionText(event),
            "arena: decision 7, SAP → KDTree: switched (bail out), reward 0.731");
  v1::DecisionEvent held;
  held.set_scene("arena");
  held.set_decision_id(8);
  held.set_active_arm("SAP");
  held.set_outcome(v1::DECISION_OUTCOME_NO_FRAMES);
  EXPECT_EQ(DecisionText(held), "arena: decision 8, SAP: no frames");
}

}  // namespace
}  // namespace sweepstake::cli
