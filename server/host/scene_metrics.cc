#include "server/host/scene_metrics.h"

#include <optional>
#include <string>
#include <utility>

#include "engine_client/decider/policy/regime_report.h"

namespace sweepstake::server {
namespace {

using alerts::AlertFigures;
using alerts::SceneFigures;
using Label = prometheus::ClientMetric::Label;

constexpr double kSecondsPerUs = 1e-6;

prometheus::MetricFamily Gauges(std::string name, std::string help) {
  prometheus::MetricFamily family;
  family.name = std::move(name);
  family.help = std::move(help);
  family.type = prometheus::MetricType::Gauge;
  return family;
}

void Add(prometheus::MetricFamily& family, std::vector<Label> labels, double value) {
  prometheus::ClientMetric& metric = family.metric.emplace_back();
  metric.label = std::move(labels);
  metric.gauge.value = value;
}

// Adds a value of the scene, if it is known.
void Add(prometheus::MetricFamily& family, const SceneFigures& scene, std::optional<double> value,
         std::optional<Label> further = {}) {
  if (!value) return;
  std::vector<Label> labels = {
      {"project", scene.project}, {"scene", scene.scene}, {"machine_class", scene.machine_class}};
  if (further) labels.push_back(*std::move(further));
  Add(family, std::move(labels), *value);
}

std::optional<double> Seconds(std::optional<double> us) {
  return us ? std::optional(*us * kSecondsPerUs) : std::nullopt;
}

prometheus::MetricFamily Alerts(const alerts::AlertCounts& counts) {
  auto family = Gauges("sweepstake_alerts", "Alerts, by rule and whether a person silenced them.");
  for (size_t i = 0; i < alerts::kRuleNames.size(); ++i) {
    const Label rule = {"rule", std::string(alerts::kRuleNames[i])};
    Add(family, {rule, {"silenced", "false"}}, counts.announced[i]);
    Add(family, {rule, {"silenced", "true"}}, counts.silenced[i]);
  }
  return family;
}

}  // namespace

std::vector<prometheus::MetricFamily> AlertFamilies(const AlertFigures& figures) {
  auto sessions = Gauges("sweepstake_scene_sessions", "Connected sessions of the scene.");
  auto saved =
      Gauges("sweepstake_scene_frame_saving_seconds",
             "Time per frame that the choices have saved in a session of the scene, against "
             "the arm that its game begins with, the best single arm or KDTree; a loss is "
             "negative.");
  auto loss = Gauges("sweepstake_scene_frame_loss_seconds",
                     "Time per frame that the leading arm is expected to cost more than the best.");
  auto probability = Gauges("sweepstake_scene_leader_probability",
                            "Probability that the leading arm is the best one, 0 to 1.");
  auto arm = Gauges("sweepstake_scene_active_arm_info",
                    "Always 1; the label is the arm that a session of the scene uses.");
  for (const SceneFigures& scene : figures.scenes) {
    Add(sessions, scene, scene.session_count);
    Add(saved, scene, Seconds(scene.saved_against_initial_us), Label{"against", "initial"});
    Add(saved, scene, Seconds(scene.saved_against_single_us), Label{"against", "best_single"});
    Add(saved, scene, Seconds(scene.saved_against_reference_us),
        Label{"against", std::string(decision::kReferenceArm)});
    Add(loss, scene, Seconds(scene.expected_loss_us));
    Add(probability, scene, scene.leader_probability);
    Add(arm, scene, 1, Label{"arm", scene.active_arm});
  }
  std::vector<prometheus::MetricFamily> families = {Alerts(figures.alerts)};
  for (auto* family : {&sessions, &saved, &loss, &probability, &arm}) {
    if (!family->metric.empty()) families.push_back(std::move(*family));
  }
  return families;
}

}  // namespace sweepstake::server
