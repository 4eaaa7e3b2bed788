#include "engine_client/cli/posterior_view.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine_client/cli/text_table.h"

namespace sweepstake::cli {
namespace {

constexpr int kBarWidth = 40;

double Mean(const v1::ArmPosterior& arm) {
  const double evidence = arm.posterior().alpha() + arm.posterior().beta();
  return evidence > 0 ? arm.posterior().alpha() / evidence : 0;
}

// The words of the protocol without their prefix, in lower case: "held cooldown".
std::string Words(std::string name, size_t prefix_length) {
  name.erase(0, std::min(prefix_length, name.size()));
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char character) {
    return character == '_' ? ' ' : static_cast<char>(std::tolower(character));
  });
  return name;
}

std::string OutcomeName(v1::DecisionOutcome outcome) {
  return Words(v1::DecisionOutcome_Name(outcome), sizeof("DECISION_OUTCOME_") - 1);
}

std::string ReasonName(v1::SwitchReason reason) {
  return Words(v1::SwitchReason_Name(reason), sizeof("SWITCH_REASON_") - 1);
}

}  // namespace

Interval ApproximateInterval(double alpha, double beta) {
  const double evidence = alpha + beta;
  if (!(evidence > 0)) return {};
  const double mean = alpha / evidence;
  const double deviation = std::sqrt(mean * (1 - mean) / (evidence + 1));
  return {std::max(0.0, mean - 1.96 * deviation), std::min(1.0, mean + 1.96 * deviation)};
}

std::string IntervalBar(double mean, Interval interval, int width) {
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
  text << ": " << scene.active_session_count()
       << (scene.active_session_count() == 1 ? " session" : " sessions") << " now, evidence of "
       << scene.source_count() << " in all\n";
  TextTable table({"arm", "0" + std::string(kBarWidth - 2, ' ') + "1", "mean", "95_low", "95_high",
                   "n", "windows", "bail-outs"});
  for (const v1::ArmPosterior& arm : scene.arms()) {
    const v1::BetaPosterior& posterior = arm.posterior();
    const Interval interval = ApproximateInterval(posterior.alpha(), posterior.beta());
    table.AddRow({arm.arm(), IntervalBar(Mean(arm), interval, kBarWidth), Fixed(Mean(arm), 3),
                  Fixed(interval.low, 3), Fixed(interval.high, 3),
                  Fixed(posterior.alpha() + posterior.beta(), 1),
                  std::to_string(arm.window_count()), std::to_string(arm.bail_out_count())});
  }
  table.Print(text);
  return text.str();
}

nlohmann::ordered_json PosteriorJson(const v1::ScenePosterior& scene) {
  nlohmann::ordered_json document = {{"project", scene.project()},
                                     {"scene", scene.scene()},
                                     {"machine_class", scene.machine_class()},
                                     {"reward_version", scene.reward_version()},
                                     {"active_sessions", scene.active_session_count()},
                                     {"sources", scene.source_count()},
                                     {"arms", nlohmann::ordered_json::array()}};
  for (const v1::ArmPosterior& arm : scene.arms()) {
    const v1::BetaPosterior& posterior = arm.posterior();
    const Interval interval = ApproximateInterval(posterior.alpha(), posterior.beta());
    document["arms"].push_back({{"arm", arm.arm()},
                                {"backend_version", arm.backend_version()},
                                {"alpha", posterior.alpha()},
                                {"beta", posterior.beta()},
                                {"mean", Mean(arm)},
                                {"low_95", interval.low},
                                {"high_95", interval.high},
                                {"n", posterior.alpha() + posterior.beta()},
                                {"windows", arm.window_count()},
                                {"bail_outs", arm.bail_out_count()}});
  }
  return document;
}

std::string DecisionText(const v1::DecisionEvent& event) {
  std::string text = event.scene() + ": decision " + std::to_string(event.decision_id()) + ", " +
                     event.active_arm();
  if (!event.candidate_arm().empty()) text += " → " + event.candidate_arm();
  text += ": " + OutcomeName(event.outcome());
  if (event.reason() != v1::SWITCH_REASON_UNSPECIFIED) {
    text += " (" + ReasonName(event.reason()) + ")";
  }
  if (event.has_reward()) text += ", reward " + Fixed(event.reward(), 3);
  return text;
}

}  // namespace sweepstake::cli
