#include "engine_client/cli/daemon/posterior_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "engine_client/telemetry/conversion/log_histogram.h"

namespace sweepstake::cli {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

void AddArm(const char* name, uint32_t version, double alpha, double beta,
            v1::ScenePosterior& scene) {
  v1::ArmPosterior& arm = *scene.add_arms();
  arm.set_arm(name);
  arm.set_backend_version(version);
  arm.mutable_posterior()->set_alpha(alpha);
  arm.mutable_posterior()->set_beta(beta);
}

v1::ScenePosterior SomeScene() {
  v1::ScenePosterior scene;
  scene.set_project("game");
  scene.set_scene("arena");
  scene.set_reward_version(2);
  scene.set_source_count(3);
  AddArm("SAP", 2, 30, 10, scene);
  scene.mutable_arms(0)->set_window_count(38);
  scene.mutable_arms(0)->set_visit_count(5);
  scene.mutable_arms(0)->set_effective_window_count(39.25);
  scene.mutable_arms(0)->set_unix_last_seen_s(1'800'000'000);
  return scene;
}

TEST(IntervalBar, MarksTheMeanWithinTheInterval) {
  EXPECT_EQ(IntervalBar(0.5, {0.25, 0.75}, 8), "  --|-- ");
  EXPECT_EQ(IntervalBar(1, {1, 1}, 4), "   |");
  EXPECT_EQ(IntervalBar(0, {0, 0}, 4), "|   ");
}

TEST(PosteriorText, NamesTheSceneItsSourcesAndEachArm) {
  const std::string text = PosteriorText(SomeScene());
  EXPECT_THAT(
      text,
      HasSubstr("game / arena, reward version 2: 0 sessions active, evidence from 3 in total\n"));
  EXPECT_THAT(text, HasSubstr("SAP"));
  EXPECT_THAT(text, HasSubstr("0.750"));
  EXPECT_THAT(text, ContainsRegex("39.2 +38 +5 +0\n"));
}

TEST(PosteriorText, ShowsTheValuesThatTheDaemonSent) {
  v1::ScenePosterior scene = SomeScene();
  AddArm("Grid", 2, 5, 35, scene);
  scene.set_verdict(v1::VERDICT_STABLE);
  scene.set_leader_arm("SAP");
  scene.set_expected_loss_ratio(0.0025);
  v1::ArmPosterior& leader = *scene.mutable_arms(0);
  v1::RewardPosterior& reward = *leader.mutable_posterior();
  reward.set_low_95(0.607);
  reward.set_low_50(0.706);
  reward.set_high_50(0.799);
  reward.set_high_95(0.870);
  leader.set_best_probability(0.875);
  v1::ArmPosterior& other = *scene.mutable_arms(1);
  other.set_best_probability(0.125);
  other.mutable_cost_ratio()->set_median(1.5625);
  other.mutable_cost_ratio()->set_low(1.25);
  other.mutable_cost_ratio()->set_high(1.75);
  const std::string text = PosteriorText(scene);
  EXPECT_THAT(
      text,
      HasSubstr("verdict stable: SAP is the best with probability 0.875, expected loss 0.25 %"));
  EXPECT_THAT(text, ContainsRegex("0.750 +0.607 +0.870 +- +- +- +0.875"));
  EXPECT_THAT(text, ContainsRegex("1.56 +1.25 +1.75 +0.125"));
  const auto document = PosteriorJson(scene);
  EXPECT_EQ(document["verdict"], "stable");
  EXPECT_EQ(document["leader_arm"], "SAP");
  EXPECT_EQ(document["expected_loss_ratio"], 0.0025);
  EXPECT_EQ(document["arms"][0]["low_95"], 0.607);
  EXPECT_EQ(document["arms"][0]["low_50"], 0.706);
  EXPECT_EQ(document["arms"][0]["high_50"], 0.799);
  EXPECT_EQ(document["arms"][0]["high_95"], 0.870);
  EXPECT_TRUE(document["arms"][0]["cost_ratio"].is_null());
  EXPECT_EQ(document["arms"][1]["best_probability"], 0.125);
  EXPECT_EQ(document["arms"][1]["cost_ratio_95"], (nlohmann::json{1.25, 1.75}));
}

TEST(PosteriorText, ShowsTheVerdictUnknownIfTheDaemonSentNone) {
  EXPECT_THAT(PosteriorText(SomeScene()), HasSubstr("verdict unknown\n"));
  EXPECT_TRUE(PosteriorJson(SomeScene())["arms"][0]["best_probability"].is_null());
}

v1::DecisionEvent EventWithStandings() {
  v1::DecisionEvent event;
  event.set_session_id("0af3");
  event.set_scene("arena");
  event.set_decision_id(7);
  event.set_unix_ms(1'800'000'000'123);
  event.set_policy("adaptive");
  event.set_active_arm("SAP");
  event.add_arms("SAP");
  v1::ArmStanding& standing = *event.add_standings();
  standing.set_live_window_count(38);
  standing.set_lane_visit_count(123);
  standing.set_effective_window_count(9.75);
  standing.set_best_probability(0.875);
  standing.mutable_cost_ratio()->set_median(1.25);
  standing.mutable_cost_ratio()->set_low(1.0625);
  standing.mutable_cost_ratio()->set_high(12.5);
  event.add_arms("Grid");
  event.add_standings();
  return event;
}

TEST(StandingsText, ShowsWhatTheSessionHasLearntAboutEachArm) {
  const std::string text = StandingsText(EventWithStandings());
  EXPECT_THAT(
      text,
      HasSubstr("session 0af3 of arena after decision 7 of policy adaptive, active arm SAP\n"));
  EXPECT_THAT(text, ContainsRegex("SAP +1.25 +1.06 +12.5 +0.875 +9.8 +38 +123\n"));
  EXPECT_THAT(text, ContainsRegex("Grid +- +- +- +0.000 +0.0 +0 +0\n"));
  EXPECT_EQ(StandingsText({}), "") << "nothing is learnt";
}

TEST(StandingsText, IsEmptyForAnInvalidMessage) {
  v1::DecisionEvent event = EventWithStandings();
  event.mutable_arms()->RemoveLast();
  EXPECT_EQ(StandingsText(event), "");
}

TEST(DecisionJson, ContainsWhatTheSessionHasLearntAboutEachArm) {
  const auto arms = DecisionJson(EventWithStandings())["arms"];
  ASSERT_EQ(arms.size(), 2U);
  EXPECT_EQ(arms[0]["arm"], "SAP");
  EXPECT_EQ(arms[0]["n"], 9.75);
  EXPECT_EQ(arms[0]["live_windows"], 38);
  EXPECT_EQ(arms[0]["lane_visits"], 123);
  EXPECT_EQ(arms[0]["cost_ratio_95"], (std::vector<double>{1.0625, 12.5}));
  EXPECT_TRUE(arms[1]["cost_ratio"].is_null());
  EXPECT_TRUE(DecisionJson({})["arms"].empty());
  EXPECT_EQ(DecisionJson(EventWithStandings())["unix_ms"], 1'800'000'000'123);
}

TEST(PosteriorJson, ContainsTheNumbersOfEachArm) {
  const auto document = PosteriorJson(SomeScene());
  EXPECT_EQ(document["arms"][0]["alpha"], 30);
  EXPECT_EQ(document["arms"][0]["windows"], 38);
  EXPECT_EQ(document["arms"][0]["lane_visits"], 5);
  EXPECT_EQ(document["arms"][0]["n"], 39.25);
  EXPECT_EQ(document["arms"][0]["unix_last_seen_s"], 1'800'000'000);
  EXPECT_EQ(document["sources"], 3);
}

TEST(PosteriorJson, HasNoProbabilityForAnOutdatedVersionOfAnArm) {
  v1::ScenePosterior scene = SomeScene();
  scene.mutable_arms(0)->set_best_probability(0.5);
  AddArm("SAP", 1, 90, 1, scene);
  scene.mutable_arms(1)->set_is_outdated(true);
  const auto document = PosteriorJson(scene);
  EXPECT_EQ(document["arms"][0]["best_probability"], 0.5);
  EXPECT_TRUE(document["arms"][1]["best_probability"].is_null());
}

TEST(PosteriorJson, TreatsAnInvalidDistributionAsUnknown) {
  v1::ScenePosterior scene = SomeScene();
  AddArm("Grid", 2, 0, -3, scene);
  EXPECT_TRUE(PosteriorJson(scene)["arms"][1]["best_probability"].is_null());
}

TEST(DecisionText, StatesTheOutcomeForTheCandidate) {
  v1::DecisionEvent event;
  event.set_scene("arena");
  event.set_decision_id(7);
  event.set_active_arm("SAP");
  event.set_candidate_arm("KDTree");
  event.set_outcome(v1::DECISION_OUTCOME_SWITCHED);
  event.set_reason(v1::SWITCH_REASON_BAIL_OUT);
  event.set_reward(0.7312);
  event.set_verdict(v1::VERDICT_AMBIGUOUS);
  EXPECT_EQ(DecisionText(event),
            "arena: decision 7, SAP → KDTree: switched (bail out), reward 0.731, ambiguous");
  v1::DecisionEvent held;
  held.set_scene("arena");
  held.set_decision_id(8);
  held.set_active_arm("SAP");
  held.set_outcome(v1::DECISION_OUTCOME_NO_FRAMES);
  EXPECT_EQ(DecisionText(held), "arena: decision 8, SAP: no frames");
}

// Returns a histogram with `count` values in each bucket. The buckets are in ascending order.
v1::LogHistogram HistogramOf(
    std::initializer_list<std::pair<uint32_t, uint32_t>> bucket_and_count) {
  v1::LogHistogram histogram;
  uint32_t before = 0;
  for (const auto& [bucket, count] : bucket_and_count) {
    histogram.add_bucket_steps(bucket - std::exchange(before, bucket));
    histogram.add_counts(count);
  }
  return histogram;
}

TEST(Quantile, IsTheMiddleOfTheBucketThatContainsTheRank) {
  const v1::LogHistogram histogram = HistogramOf({{0, 10}, {161, 80}, {177, 9}, {185, 1}});
  EXPECT_EQ(QuantileOf(histogram, 0.1), 0.0);
  EXPECT_NEAR(*QuantileOf(histogram, 0.11), 1'048'576, 0.045 * 1'048'576);
  EXPECT_EQ(QuantileOf(histogram, 0.9), QuantileOf(histogram, 0.5));
  EXPECT_DOUBLE_EQ(*QuantileOf(histogram, 0.95), 4 * *QuantileOf(histogram, 0.5));
  EXPECT_DOUBLE_EQ(*QuantileOf(histogram, 1), 8 * *QuantileOf(histogram, 0.5));
}

TEST(Quantile, IsAbsentWithoutValuesAndForAnInvalidMessage) {
  EXPECT_EQ(QuantileOf({}, 0.5), std::nullopt);
  v1::LogHistogram broken = HistogramOf({{161, 80}});
  broken.add_counts(1);
  EXPECT_EQ(QuantileOf(broken, 0.5), std::nullopt);
}

TEST(DecisionJson, ContainsTheDecisionAndTheBeliefs) {
  v1::DecisionEvent event;
  event.set_policy("paper");
  event.set_machine_class("desktop");
  for (const double probability : {0.25, 0.75}) event.add_best_probability(probability);
  event.set_expected_loss_ratio(0.125);
  const auto json = DecisionJson(event);
  EXPECT_EQ(json["policy"], "paper");
  EXPECT_EQ(json["machine_class"], "desktop");
  EXPECT_EQ(json["best_probability"], (std::vector<double>{0.25, 0.75}));
  EXPECT_EQ(json["expected_loss_ratio"], 0.125);
}

TEST(DecisionJson, ContainsThePercentilesOfTheText) {
  v1::DecisionEvent event;
  event.set_scene("arena");
  event.set_decision_id(9);
  event.set_active_arm("SAP");
  event.set_outcome(v1::DECISION_OUTCOME_KEPT);
  EXPECT_FALSE(DecisionJson(event).contains("frame_ms"));
  v1::FrameMeasurements& measurements = *event.mutable_measurements();
  *measurements.mutable_frame_time_ns() = HistogramOf({{192, 94}, {200, 4}, {208, 2}});
  *measurements.mutable_detection_time_ns() = HistogramOf({{168, 100}});
  *measurements.mutable_native_bytes() = HistogramOf({{161, 100}});
  EXPECT_EQ(DecisionText(event),
            "arena: decision 9, SAP: kept; p50/p95/p99 of the frame 16.1/32.1/64.3 ms, detection "
            "2.01/2.01/2.01 ms");
  const auto json = DecisionJson(event);
  EXPECT_EQ(json["outcome"], "kept");
  EXPECT_NEAR(json["frame_ms"]["p50"], 16.1, 0.1);
  EXPECT_NEAR(json["frame_ms"]["p99"], 64.3, 0.1);
  EXPECT_NEAR(json["detection_ms"]["p95"], 2.01, 0.01);
  EXPECT_NEAR(json["native_bytes"]["p50"], 1'048'576, 0.045 * 1'048'576);
}

}  // namespace
}  // namespace sweepstake::cli
