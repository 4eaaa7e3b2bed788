// Tests the metrics of alerts and of single scenes.
#include "server/host/scene_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "server/web/metrics_page.h"

namespace sweepstake::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string PageOf(const alerts::AlertFigures& figures) {
  return web::MetricsPage(AlertFamilies(figures)).body;
}

alerts::SceneFigures Harbour() {
  alerts::SceneFigures scene;
  scene.project = "game";
  scene.scene = "harbour";
  scene.machine_class = "desktop";
  scene.session_count = 3;
  scene.active_arm = "Grid";
  scene.leader_probability = 0.75;
  scene.expected_loss_us = 125'000;
  scene.saved_against_initial_us = 375'000;
  scene.saved_against_single_us = -250'000;
  scene.saved_against_reference_us = 500'000;
  return scene;
}

TEST(SceneMetricsTest, EveryFigureOfASceneIsAGaugeInBaseUnits) {
  const std::string page = PageOf({.alerts = {}, .scenes = {Harbour()}});
  const std::string labels = "{project=\"game\",scene=\"harbour\",machine_class=\"desktop\"";
  for (const std::string& line :
       {"sweepstake_scene_sessions" + labels + "} 3\n",
        "sweepstake_scene_frame_saving_seconds" + labels + ",against=\"initial\"} 0.375\n",
        "sweepstake_scene_frame_saving_seconds" + labels + ",against=\"best_single\"} -0.25\n",
        "sweepstake_scene_frame_saving_seconds" + labels + ",against=\"KDTree\"} 0.5\n",
        "sweepstake_scene_frame_loss_seconds" + labels + "} 0.125\n",
        "sweepstake_scene_leader_probability" + labels + "} 0.75\n",
        "sweepstake_scene_active_arm_info" + labels + ",arm=\"Grid\"} 1\n"}) {
    EXPECT_THAT(page, HasSubstr(line));
  }
}

TEST(SceneMetricsTest, AnUnknownFigureHasNoSeries) {
  alerts::SceneFigures scene = Harbour();
  scene.expected_loss_us.reset();
  scene.saved_against_single_us.reset();
  const std::string page = PageOf({.alerts = {}, .scenes = {scene}});
  EXPECT_THAT(page, Not(HasSubstr("frame_loss")));
  EXPECT_THAT(page, Not(HasSubstr("best_single")));
  EXPECT_THAT(page, HasSubstr("against=\"KDTree\""));
}

TEST(SceneMetricsTest, NamesInLabelsAreEscaped) {
  alerts::SceneFigures scene = Harbour();
  scene.scene = "a\"b\\c";
  EXPECT_THAT(PageOf({.alerts = {}, .scenes = {scene}}), HasSubstr(R"(scene="a\"b\\c")"));
}

TEST(SceneMetricsTest, WithoutScenesOnlyTheAlertsRemain) {
  const std::string page = PageOf({});
  EXPECT_THAT(page, Not(HasSubstr("sweepstake_scene_")));
  EXPECT_THAT(page, HasSubstr("sweepstake_alerts{rule=\"degraded\",silenced=\"false\"} 0"));
}

TEST(SceneMetricsTest, AlertsAreCountedByRule) {
  alerts::AlertFigures figures;
  figures.alerts.announced[static_cast<size_t>(alerts::Rule::kAmbiguous)] = 12;
  figures.alerts.silenced[static_cast<size_t>(alerts::Rule::kManual)] = 2;
  const std::string page = PageOf(figures);
  EXPECT_THAT(page, HasSubstr("sweepstake_alerts{rule=\"ambiguous\",silenced=\"false\"} 12"));
  EXPECT_THAT(page, HasSubstr("sweepstake_alerts{rule=\"manual\",silenced=\"true\"} 2"));
}

}  // namespace
}  // namespace sweepstake::server
