#include "engine_client/cli/daemon/activity_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "engine_client/cli/daemon/posterior_view.h"

namespace sweepstake::cli {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

v1::RegimePosterior Regime(const std::string& best_arm, float sap_us, float dbvt_us) {
  v1::RegimePosterior regime;
  regime.set_best_arm(best_arm);
  for (const float cost_us : {sap_us, dbvt_us}) {
    v1::RegimeArm& arm = *regime.add_arms();
    arm.set_cost_us(cost_us);
    arm.set_low_us(cost_us - 10);
    arm.set_high_us(cost_us + 10);
    arm.set_best_probability(0.5F);
  }
  return regime;
}

// A scene that moves most of the time, where DBVT is the best, and rests otherwise.
v1::ScenePosterior ChangingScene() {
  v1::ScenePosterior scene;
  scene.set_project("game");
  scene.set_scene("arena");
  scene.set_verdict(v1::VERDICT_STABLE);
  v1::SceneActivity& activity = *scene.mutable_activity();
  activity.set_session_id("0af3");
  activity.set_active_arm("SAP");
  activity.set_initial_arm("SAP");
  activity.set_unix_active_since_ms(1'800'000'000'000);
  activity.set_recent_switch_count(6);
  activity.set_is_changing(true);
  activity.add_arms("SAP");
  activity.add_arms("DBVT");
  *activity.mutable_total() = Regime("DBVT", 122.5F, 112.5F);
  activity.mutable_total()->set_frame_share(1);
  activity.mutable_total()->set_ran_us(97.5F);
  activity.mutable_total()->set_saved_against_single_us(15);
  activity.mutable_total()->set_saved_against_reference_us(-2.5F);
  activity.mutable_total()->set_saved_against_initial_us(25);
  v1::RegimePosterior& moving = *activity.add_regimes() = Regime("DBVT", 140, 100);
  moving.set_object_count(2'000);
  moving.set_speed_mean(0.125F);
  moving.set_static_ratio(0.25F);
  moving.set_frame_share(0.75F);
  v1::RegimePosterior& resting = *activity.add_regimes() = Regime("SAP", 90, 150);
  resting.set_is_present(true);
  resting.set_frame_share(0.25F);
  return scene;
}

TEST(ActivityText, SaysWhatRunsAndWhatItSaved) {
  const std::string text = ActivityText(ChangingScene());
  EXPECT_THAT(text, HasSubstr("session 0af3 runs SAP since 2027-01-15 08:00:00, 6 switches in the "
                              "last minute\n"));
  EXPECT_THAT(text,
              HasSubstr("saved per frame: 0.0250 ms against always SAP, the arm that the game "
                        "begins with\n"
                        "saved per frame: 0.0150 ms against always DBVT, the best single arm\n"
                        "saved per frame: -0.0025 ms against always KDTree\n"));
}

TEST(ActivityText, NamesKDTreeOnceIfTheGameBeginsWithIt) {
  v1::ScenePosterior scene = ChangingScene();
  scene.mutable_activity()->set_initial_arm("KDTree");
  const std::string text = ActivityText(scene);
  EXPECT_THAT(text, HasSubstr("always KDTree, the arm that the game begins with\n"));
  EXPECT_THAT(text, Not(HasSubstr("always KDTree\n")));
}

TEST(ActivityText, HasALinePerRegimeAndOneForAll) {
  const std::string text = ActivityText(ChangingScene());
  EXPECT_THAT(text, ContainsRegex("1 +2000 +0.1250 +25 % +75 % +DBVT +0.500 +100.0 +90.0 +110.0"));
  EXPECT_THAT(text, ContainsRegex("2 \\(now\\) +- +- +- +25 % +SAP +0.500 +90.0 +80.0 +100.0"));
  EXPECT_THAT(text, ContainsRegex("all +- +- +- +100 % +DBVT .* +97.5 +15.0\n"));
}

TEST(ActivityText, ReplacesTheVerdictOfAChangingScene) {
  v1::ScenePosterior scene = ChangingScene();
  EXPECT_THAT(PosteriorText(scene), HasSubstr("verdict changing: the best arm depends on the"));
  EXPECT_THAT(PosteriorText(scene), Not(HasSubstr("stable")));
  EXPECT_EQ(PosteriorJson(scene)["verdict"], "changing");
  scene.mutable_activity()->set_is_changing(false);
  scene.add_regime_arms("DBVT");
  scene.add_regime_arms("SAP");
  EXPECT_THAT(PosteriorText(scene), HasSubstr("verdict stable"));
  EXPECT_EQ(PosteriorJson(scene)["verdict"], "stable");
  scene.clear_activity();
  EXPECT_THAT(PosteriorText(scene), HasSubstr("verdict changing")) << "by the stored regimes";
  EXPECT_EQ(PosteriorJson(scene)["regime_arms"].dump(), R"(["DBVT","SAP"])");
}

TEST(ActivityText, LeavesOutWhatIsNotKnown) {
  v1::ScenePosterior scene = ChangingScene();
  v1::SceneActivity& activity = *scene.mutable_activity();
  activity.clear_regimes();
  *activity.mutable_total() = {};
  activity.mutable_total()->set_best_arm("DBVT");
  const std::string text = ActivityText(scene);
  EXPECT_THAT(text, Not(HasSubstr("saved per frame")));
  EXPECT_THAT(text, ContainsRegex("all +- +- +- +0 % +- +- +- +- +- +- +-\n"));
}

TEST(ActivityText, OfASceneWithoutASessionSaysSo) {
  EXPECT_EQ(ActivityText({}), "no session is connected; regimes are shown only during a session\n");
  EXPECT_TRUE(ActivityJson({}).is_null());
}

TEST(ActivityJson, HasAllFigures) {
  const auto document = PosteriorJson(ChangingScene())["activity"];
  EXPECT_EQ(document["session_id"], "0af3");
  EXPECT_EQ(document["active_arm"], "SAP");
  EXPECT_EQ(document["unix_active_since_ms"], 1'800'000'000'000);
  EXPECT_EQ(document["recent_switches"], 6);
  EXPECT_EQ(document["total"]["saved_against_single_us"], 15);
  EXPECT_EQ(document["total"]["saved_against_reference_us"], -2.5);
  EXPECT_EQ(document["initial_arm"], "SAP");
  EXPECT_EQ(document["total"]["saved_against_initial_us"], 25);
  EXPECT_EQ(document["total"]["ran_us"], 97.5);
  ASSERT_EQ(document["regimes"].size(), 2u);
  const auto& moving = document["regimes"][0];
  EXPECT_EQ(moving["object_count"], 2000);
  EXPECT_EQ(moving["speed_mean"], 0.125);
  EXPECT_EQ(moving["static_ratio"], 0.25);
  EXPECT_EQ(moving["frame_share"], 0.75);
  EXPECT_EQ(moving["best_arm"], "DBVT");
  EXPECT_EQ(moving["is_present"], false);
  EXPECT_EQ(moving["arms"][1]["arm"], "DBVT");
  EXPECT_EQ(moving["arms"][1]["cost_us"], 100);
  EXPECT_EQ(moving["arms"][1]["cost_us_95"], (nlohmann::json{90, 110}));
  EXPECT_EQ(moving["arms"][1]["best_probability"], 0.5);
  EXPECT_EQ(document["regimes"][1]["is_present"], true);
  EXPECT_TRUE(document["regimes"][1]["object_count"].is_null());
  EXPECT_TRUE(document["regimes"][1]["ran_us"].is_null());
}

}  // namespace
}  // namespace sweepstake::cli
