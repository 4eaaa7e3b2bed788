#include "engine_client/cli/daemon/posterior_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "engine_client/cli/daemon/activity_view.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/standing_cells.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/types.h"
#include "engine_client/telemetry/conversion/log_histogram.h"
#include "engine_client/telemetry/conversion/proto_conversion.h"

namespace sweepstake::cli {
namespace {

constexpr int kBarWidth = 30;
constexpr double kMsPerNs = 1e-6;
constexpr std::array kShares = {0.5, 0.95, 0.99};

double Mean(const v1::ArmPosterior& arm) {
  const double evidence = arm.posterior().alpha() + arm.posterior().beta();
  return evidence > 0 ? arm.posterior().alpha() / evidence : 0;
}

// Returns the value's name with spaces instead of hyphens, such as "held cooldown". The
// enumerations of the protocol and of decider/types.h have the same values.
template <typename Enum>
std::string Words(std::span<const std::string_view> names, Enum value) {
  std::string name = decision::NameOf(names, value);
  std::replace(name.begin(), name.end(), '-', ' ');
  return name;
}

std::string VerdictText(const v1::ScenePosterior& scene) {
  if (IsChanging(scene)) return "changing: the best arm depends on the regime";
  const std::string name = decision::NameOf(decision::kVerdictNames, scene.verdict());
  const auto leader = std::find_if(scene.arms().begin(), scene.arms().end(), [&](const auto& arm) {
    return arm.arm() == scene.leader_arm() && arm.has_best_probability();
  });
  if (leader == scene.arms().end()) return name;
  return name + ": " + leader->arm() + " is the best with probability " +
         Fixed(leader->best_probability(), 3) + ", expected loss " +
         Percent(scene.expected_loss_ratio(), 2) + ", possible gain from more evidence " +
         Percent(scene.value_remaining_ratio(), 2);
}

// Returns three percentiles as text, such as "16.6/17.2/31.1 ms".
std::string PercentilesText(const v1::LogHistogram& ns, int decimals) {
  std::string text;
  for (const double share : kShares) {
    const auto value = QuantileOf(ns, share);
    text += (text.empty() ? "" : "/") + (value ? Fixed(*value * kMsPerNs, decimals) : "-");
  }
  return text + " ms";
}

Json PercentilesJson(const v1::LogHistogram& histogram, double unit) {
  Json document = Json::object();
  for (const double share : kShares) {
    const auto value = QuantileOf(histogram, share);
    if (value) document["p" + Fixed(100 * share, 0)] = *value * unit;
  }
  return document;
}

}  // namespace

std::string IntervalBar(double mean, decision::CredibleInterval interval, int width) {
  const auto column = [&](double value) {
    return static_cast<size_t>(
        std::min(static_cast<int>(std::clamp(value, 0.0, 1.0) * width), width - 1));
  };
  std::string bar(static_cast<size_t>(width), ' ');
  std::fill(bar.begin() + static_cast<std::ptrdiff_t>(column(interval.low)),
            bar.begin() + static_cast<std::ptrdiff_t>(column(interval.high)) + 1, '-');
  bar[column(mean)] = '|';
  return bar;
}

std::string PosteriorText(const v1::ScenePosterior& scene) {
  std::ostringstream text;
  text << scene.project() << " / " << scene.scene();
  if (!scene.machine_class().empty()) text << " on " << scene.machine_class();
  text << ", reward version " << scene.reward_version() << ": " << scene.active_session_count()
       << (scene.active_session_count() == 1 ? " session" : " sessions")
       << " active, evidence from " << scene.source_count() << " in total\n"
       << "verdict " << VerdictText(scene) << '\n';
  TextTable table({"arm", "0" + std::string(kBarWidth - 2, ' ') + "1", "mean", "95_low", "95_high",
                   "cost", "95_low", "95_high", "best", "equiv", "windows", "visits", "bail-outs"});
  for (const v1::ArmPosterior& arm : scene.arms()) {
    const decision::CredibleInterval interval = {arm.posterior().low_95(),
                                                 arm.posterior().high_95()};
    const bool has_ratio = arm.has_cost_ratio();
    table.AddRow({arm.arm(), IntervalBar(Mean(arm), interval, kBarWidth), Fixed(Mean(arm), 3),
                  Fixed(interval.low, 3), Fixed(interval.high, 3),
                  has_ratio ? RatioText(arm.cost_ratio().median()) : "-",
                  has_ratio ? RatioText(arm.cost_ratio().low()) : "-",
                  has_ratio ? RatioText(arm.cost_ratio().high()) : "-",
                  arm.has_best_probability() ? Fixed(arm.best_probability(), 3) : "-",
                  Fixed(arm.effective_window_count(), 1), std::to_string(arm.window_count()),
                  std::to_string(arm.visit_count()), std::to_string(arm.bail_out_count())});
  }
  return text.str() + ActivityText(scene) + table.Text();
}

Json PosteriorJson(const v1::ScenePosterior& scene) {
  Json document = {
      {"project", scene.project()},
      {"scene", scene.scene()},
      {"machine_class", scene.machine_class()},
      {"reward_version", scene.reward_version()},
      {"active_sessions", scene.active_session_count()},
      {"sources", scene.source_count()},
      {"verdict",
       IsChanging(scene) ? "changing" : decision::NameOf(decision::kVerdictNames, scene.verdict())},
      {"leader_arm", scene.leader_arm()},
      {"regime_arms", scene.regime_arms()},
      {"expected_loss_ratio", scene.expected_loss_ratio()},
      {"value_remaining_ratio", scene.value_remaining_ratio()},
      {"activity", ActivityJson(scene)},
      {"arms", Json::array()}};
  for (const v1::ArmPosterior& arm : scene.arms()) {
    const v1::RewardPosterior& posterior = arm.posterior();
    const v1::CostRatio& ratio = arm.cost_ratio();
    document["arms"].push_back(
        {{"arm", arm.arm()},
         {"backend_version", arm.backend_version()},
         {"alpha", posterior.alpha()},
         {"beta", posterior.beta()},
         {"mean", Mean(arm)},
         {"low_95", posterior.low_95()},
         {"low_50", posterior.low_50()},
         {"high_50", posterior.high_50()},
         {"high_95", posterior.high_95()},
         {"best_probability", arm.has_best_probability() ? Json(arm.best_probability()) : Json()},
         {"cost_ratio", arm.has_cost_ratio() ? Json(ratio.median()) : Json()},
         {"cost_ratio_95",
          arm.has_cost_ratio() ? IntervalJson({ratio.low(), ratio.high()}) : Json()},
         {"windows", arm.window_count()},
         {"lane_visits", arm.visit_count()},
         {"n", arm.effective_window_count()},
         {"bail_outs", arm.bail_out_count()},
         {"unix_last_seen_s", arm.unix_last_seen_s()}});
  }
  return document;
}

std::string PosteriorsText(std::span<const v1::ScenePosterior> scenes) {
  if (scenes.empty()) return "The daemon has no matching posteriors yet\n";
  std::string text;
  for (const v1::ScenePosterior& scene : scenes) text += PosteriorText(scene) + '\n';
  return text;
}

Json PosteriorsJson(std::span<const v1::ScenePosterior> scenes) {
  Json list = Json::array();
  for (const v1::ScenePosterior& scene : scenes) list.push_back(PosteriorJson(scene));
  return list;
}

std::string StandingsText(const v1::DecisionEvent& event) {
  if (event.standings_size() == 0 || event.standings_size() != event.arms_size()) return "";
  std::vector<std::string> header = StandingHeader();
  header.insert(header.begin(), "arm");
  TextTable table(header);
  for (int i = 0; i < event.arms_size(); ++i) {
    std::vector<std::string> cells = StandingCells(FromProto(event.standings(i)));
    cells.insert(cells.begin(), event.arms(i));
    table.AddRow(std::move(cells));
  }
  return "session " + event.session_id() + " of " + event.scene() + " after decision " +
         std::to_string(event.decision_id()) + " of policy " + event.policy() + ", active arm " +
         event.active_arm() + '\n' + table.Text();
}

std::string DecisionText(const v1::DecisionEvent& event) {
  std::string text = event.scene() + ": decision " + std::to_string(event.decision_id()) + ", " +
                     event.active_arm();
  if (!event.candidate_arm().empty()) text += " → " + event.candidate_arm();
  text += ": " + Words(decision::kOutcomeNames, event.outcome());
  if (event.reason() != v1::SWITCH_REASON_UNSPECIFIED) {
    text += " (" + Words(decision::kSwitchReasonNames, event.reason()) + ")";
  }
  if (event.has_reward()) text += ", reward " + Fixed(event.reward(), 3);
  if (event.verdict() != v1::VERDICT_UNSPECIFIED) {
    text += ", " + Words(decision::kVerdictNames, event.verdict());
  }
  if (event.has_measurements()) {
    text += "; p50/p95/p99 of the frame " +
            PercentilesText(event.measurements().frame_time_ns(), 1) + ", detection " +
            PercentilesText(event.measurements().detection_time_ns(), 2);
  }
  return text;
}

Json DecisionJson(const v1::DecisionEvent& event) {
  Json document = {{"session_id", event.session_id()},
                   {"project", event.project()},
                   {"scene", event.scene()},
                   {"decision_id", event.decision_id()},
                   {"unix_ms", event.unix_ms()},
                   {"active_arm", event.active_arm()},
                   {"candidate_arm", event.candidate_arm()},
                   {"outcome", decision::NameOf(decision::kOutcomeNames, event.outcome())}};
  if (event.reason() != v1::SWITCH_REASON_UNSPECIFIED)
    document["reason"] = decision::NameOf(decision::kSwitchReasonNames, event.reason());
  if (event.has_reward()) document["reward"] = event.reward();
  document["policy"] = event.policy();
  document["machine_class"] = event.machine_class();
  document["best_probability"] = event.best_probability();
  document["arms"] = Json::array();
  for (int i = 0; i < std::min(event.arms_size(), event.standings_size()); ++i)
    AddStanding(FromProto(event.standings(i)),
                document["arms"].emplace_back(Json{{"arm", event.arms(i)}}));
  document["expected_loss_ratio"] = event.expected_loss_ratio();
  document["verdict"] = decision::NameOf(decision::kVerdictNames, event.verdict());
  if (!event.has_measurements()) return document;
  document["frame_ms"] = PercentilesJson(event.measurements().frame_time_ns(), kMsPerNs);
  document["detection_ms"] = PercentilesJson(event.measurements().detection_time_ns(), kMsPerNs);
  document["native_bytes"] = PercentilesJson(event.measurements().native_bytes(), 1);
  return document;
}

}  // namespace sweepstake::cli
