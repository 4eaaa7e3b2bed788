#include "engine_client/cli/daemon/posterior_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/standing_cells.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/audit/cell_text.h"
#include "engine_client/decider/embedded/decision_conversion.h"
#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/telemetry/proto_conversion.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBarWidth = 30;
constexpr double kMsPerNs = 1e-6;
constexpr std::array kShares = {0.5, 0.95, 0.99};

double Mean(const v1::ArmPosterior& arm) {
  const double evidence = arm.posterior().alpha() + arm.posterior().beta();
  return evidence > 0 ? arm.posterior().alpha() / evidence : 0;
}

// Returns the value's name with spaces: "held cooldown". The protocol's values are those of the
// decision core.
template <typename Enum>
std::string Words(std::span<const std::string_view> names, Enum value) {
  std::string name = decision::NameOf(names, value);
  std::replace(name.begin(), name.end(), '-', ' ');
  return name;
}

// The values computed for an arm from the posteriors that the daemon sent.
struct ArmView {
  decision::CredibleInterval interval;
  // Absent if nothing is known of the arm or its backend has a newer version.
  std::optional<double> best_probability;
  std::optional<CostRatio> cost_ratio;  // absent as well where rewards do not tell costs
};

struct SceneView {
  std::vector<ArmView> arms;  // in the order of the scene's arms
  decision::Diagnosis diagnosis;
  std::string leader;
};

bool IsNewest(const v1::ScenePosterior& scene, const v1::ArmPosterior& arm) {
  return std::none_of(scene.arms().begin(), scene.arms().end(), [&](const v1::ArmPosterior& other) {
    return other.arm() == arm.arm() && other.backend_version() > arm.backend_version();
  });
}

decision::Diagnosis DiagnoseCosts(std::span<const decision::BetaPosterior> posteriors) {
  const bool nothing_learnt =
      std::all_of(posteriors.begin(), posteriors.end(),
                  [](const auto& posterior) { return posterior == decision::BetaPosterior{}; });
  if (nothing_learnt) return {};
  std::vector<double> means, variances;
  for (const decision::BetaPosterior& posterior : posteriors) {
    const decision::NormalBelief belief = decision::BeliefOf(posterior);
    means.push_back(belief.mean);
    variances.push_back(belief.variance);
  }
  return decision::DiagnoseLogCosts(means, variances);
}

SceneView ViewOf(const v1::ScenePosterior& scene) {
  SceneView view;
  std::vector<decision::BetaPosterior> contenders;
  std::vector<size_t> places;
  for (const v1::ArmPosterior& arm : scene.arms()) {
    ArmView& shown = view.arms.emplace_back();
    const auto belief = FromProto(arm.posterior(), arm.arm());
    if (!belief) continue;
    const decision::BetaPosterior posterior = ToDecision(*belief);
    shown.interval = decision::CentralInterval(posterior, 0.95);
    if (!IsNewest(scene, arm)) continue;
    contenders.push_back(posterior);
    places.push_back(view.arms.size() - 1);
  }
  // The only arm that is known of is no better than others.
  if (contenders.size() < 2) return view;
  const bool tells_costs = scene.reward_version() == decision::kLogCostRewardVersion;
  view.diagnosis = tells_costs ? DiagnoseCosts(contenders) : decision::Diagnose(contenders);
  if (view.diagnosis.best_probability.empty()) return view;
  const uint32_t leader = view.diagnosis.leader;
  view.leader = scene.arms(static_cast<int>(places[leader])).arm();
  for (size_t i = 0; i < contenders.size(); ++i) {
    ArmView& shown = view.arms[places[i]];
    shown.best_probability = view.diagnosis.best_probability[i];
    if (!tells_costs) continue;
    const decision::CostRatio ratio =
        i == leader ? decision::CostRatio{}
                    : decision::CostRatioOf(contenders[i], contenders[leader]);
    shown.cost_ratio = CostRatio{.median = ratio.median, .low = ratio.low, .high = ratio.high};
  }
  return view;
}

std::string VerdictText(const SceneView& view) {
  const decision::Diagnosis& diagnosis = view.diagnosis;
  const std::string name = decision::NameOf(decision::kVerdictNames, diagnosis.verdict);
  if (view.leader.empty()) return name;
  return name + ": " + view.leader + " is the best with probability " +
         Fixed(diagnosis.best_probability[diagnosis.leader], 3) + ", choosing it loses " +
         Percent(diagnosis.expected_loss_ratio, 2) + ", knowing all would gain " +
         Percent(diagnosis.value_remaining_ratio, 2);
}

// Returns, for example, "16.6/17.2/31.1 ms".
std::string PercentilesText(const v1::LogHistogram& ns, int decimals) {
  std::string text;
  for (const double share : kShares) {
    const auto value = Quantile(ns, share);
    text += (text.empty() ? "" : "/") + (value ? Fixed(*value * kMsPerNs, decimals) : "-");
  }
  return text + " ms";
}

Json PercentilesJson(const v1::LogHistogram& histogram, double unit) {
  Json document = Json::object();
  for (const double share : kShares) {
    const auto value = Quantile(histogram, share);
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
  const SceneView view = ViewOf(scene);
  std::ostringstream text;
  text << scene.project() << " / " << scene.scene();
  if (!scene.machine_class().empty()) text << " on " << scene.machine_class();
  text << ", reward version " << scene.reward_version() << ": " << scene.active_session_count()
       << (scene.active_session_count() == 1 ? " session" : " sessions") << " now, evidence of "
       << scene.source_count() << " in all\n"
       << "verdict " << VerdictText(view) << '\n';
  TextTable table({"arm", "0" + std::string(kBarWidth - 2, ' ') + "1", "mean", "95_low", "95_high",
                   "cost", "95_low", "95_high", "best", "n", "windows", "visits", "bail-outs"});
  for (int i = 0; i < scene.arms_size(); ++i) {
    const v1::ArmPosterior& arm = scene.arms(i);
    const auto& [interval, best, ratio] = view.arms[static_cast<size_t>(i)];
    table.AddRow({arm.arm(), IntervalBar(Mean(arm), interval, kBarWidth), Fixed(Mean(arm), 3),
                  Fixed(interval.low, 3), Fixed(interval.high, 3),
                  ratio ? RatioText(ratio->median) : "-", ratio ? RatioText(ratio->low) : "-",
                  ratio ? RatioText(ratio->high) : "-", best ? Fixed(*best, 3) : "-",
                  Fixed(arm.effective_window_count(), 1), std::to_string(arm.window_count()),
                  std::to_string(arm.visit_count()), std::to_string(arm.bail_out_count())});
  }
  return text.str() + table.Text();
}

Json PosteriorJson(const v1::ScenePosterior& scene) {
  const SceneView view = ViewOf(scene);
  Json document = {{"project", scene.project()},
                   {"scene", scene.scene()},
                   {"machine_class", scene.machine_class()},
                   {"reward_version", scene.reward_version()},
                   {"active_sessions", scene.active_session_count()},
                   {"sources", scene.source_count()},
                   {"verdict", decision::NameOf(decision::kVerdictNames, view.diagnosis.verdict)},
                   {"leader_arm", view.leader},
                   {"expected_loss_ratio", view.diagnosis.expected_loss_ratio},
                   {"value_remaining_ratio", view.diagnosis.value_remaining_ratio},
                   {"arms", Json::array()}};
  for (int i = 0; i < scene.arms_size(); ++i) {
    const v1::ArmPosterior& arm = scene.arms(i);
    const v1::BetaPosterior& posterior = arm.posterior();
    const auto& [interval, best, ratio] = view.arms[static_cast<size_t>(i)];
    document["arms"].push_back(
        {{"arm", arm.arm()},
         {"backend_version", arm.backend_version()},
         {"alpha", posterior.alpha()},
         {"beta", posterior.beta()},
         {"mean", Mean(arm)},
         {"low_95", interval.low},
         {"high_95", interval.high},
         {"best_probability", OrNull(best)},
         {"cost_ratio", ratio ? Json(ratio->median) : Json()},
         {"cost_ratio_95", ratio ? IntervalJson({ratio->low, ratio->high}) : Json()},
         {"windows", arm.window_count()},
         {"lane_visits", arm.visit_count()},
         {"n", arm.effective_window_count()},
         {"bail_outs", arm.bail_out_count()},
         {"unix_last_seen_s", arm.unix_last_seen_s()}});
  }
  return document;
}

std::string PosteriorsText(std::span<const v1::ScenePosterior> scenes) {
  if (scenes.empty()) return "The daemon has no posteriors of this yet\n";
  std::string text;
  for (const v1::ScenePosterior& scene : scenes) text += PosteriorText(scene) + '\n';
  return text;
}

Json PosteriorsJson(std::span<const v1::ScenePosterior> scenes) {
  Json list = Json::array();
  for (const v1::ScenePosterior& scene : scenes) list.push_back(PosteriorJson(scene));
  return list;
}

std::optional<double> Quantile(const v1::LogHistogram& histogram, double share) {
  if (histogram.counts_size() != histogram.bucket_steps_size()) return std::nullopt;
  uint64_t total = 0;
  for (const uint32_t count : histogram.counts()) total += count;
  if (total == 0) return std::nullopt;
  const double rank = std::max(1.0, std::ceil(share * static_cast<double>(total)));
  uint64_t bucket = 0;
  uint64_t below = 0;
  for (int i = 0; i < histogram.counts_size() && static_cast<double>(below) < rank; ++i) {
    bucket += histogram.bucket_steps(i);
    below += histogram.counts(i);
  }
  return bucket == 0 ? 0 : std::exp2((static_cast<double>(bucket) - 0.5) / 8);
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
         std::to_string(event.decision_id()) + " of policy " + event.policy() + ", on " +
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
