#include "engine_client/cli/daemon/activity_view.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/policy/regime_report.h"

namespace sweepstake::cli {
namespace {

constexpr double kMsPerUs = 1e-3;

// Returns the belief about the regime's best arm, if there is one.
const v1::RegimeArm* BestOf(const v1::RegimePosterior& regime, const v1::SceneActivity& activity) {
  const int count = std::min(regime.arms_size(), activity.arms_size());
  for (int i = 0; i < count; ++i) {
    if (activity.arms(i) == regime.best_arm()) return &regime.arms(i);
  }
  return nullptr;
}

std::string CellOf(bool is_present, double value, int decimals) {
  return is_present ? Fixed(value, decimals) : "-";
}

std::vector<std::string> RowOf(const std::string& name, const v1::RegimePosterior& regime,
                               const v1::SceneActivity& activity) {
  const v1::RegimeArm* best = BestOf(regime, activity);
  const bool has_cost = best != nullptr && best->cost_us() > 0;
  return {name,
          CellOf(regime.has_object_count(), regime.object_count(), 0),
          CellOf(regime.has_speed_mean(), regime.speed_mean(), 4),
          regime.has_static_ratio() ? Percent(regime.static_ratio(), 0) : "-",
          Percent(regime.frame_share(), 0),
          best == nullptr ? "-" : regime.best_arm(),
          best == nullptr ? "-" : Fixed(best->best_probability(), 3),
          CellOf(has_cost, has_cost ? best->cost_us() : 0, 1),
          CellOf(has_cost, has_cost ? best->low_us() : 0, 1),
          CellOf(has_cost, has_cost ? best->high_us() : 0, 1),
          CellOf(regime.has_ran_us(), regime.ran_us(), 1),
          CellOf(regime.has_saved_against_single_us(), regime.saved_against_single_us(), 1)};
}

// Returns a line about the saving against one arm. `what` says why the arm is a baseline.
std::string SavingText(double saved_us, const std::string& arm, const std::string& what) {
  return "saved per frame: " + Fixed(saved_us * kMsPerUs, 4) + " ms against always " + arm + what +
         '\n';
}

// Returns a line for each arm whose saving is known. The reference arm has no line if it is the
// initial arm.
std::string SavingsText(const v1::SceneActivity& activity) {
  const v1::RegimePosterior& total = activity.total();
  std::string text;
  if (total.has_saved_against_initial_us()) {
    text += SavingText(total.saved_against_initial_us(), activity.initial_arm(),
                       ", the arm that the game begins with");
  }
  if (total.has_saved_against_single_us()) {
    text += SavingText(total.saved_against_single_us(), total.best_arm(), ", the best single arm");
  }
  if (total.has_saved_against_reference_us() && activity.initial_arm() != decision::kReferenceArm) {
    text +=
        SavingText(total.saved_against_reference_us(), std::string(decision::kReferenceArm), "");
  }
  return text;
}

template <typename Value>
Json JsonIf(bool is_present, Value value) {
  return is_present ? Json(value) : Json();
}

Json RegimeJson(const v1::RegimePosterior& regime, const v1::SceneActivity& activity) {
  Json document = {{"object_count", JsonIf(regime.has_object_count(), regime.object_count())},
                   {"speed_mean", JsonIf(regime.has_speed_mean(), regime.speed_mean())},
                   {"static_ratio", JsonIf(regime.has_static_ratio(), regime.static_ratio())},
                   {"is_present", regime.is_present()},
                   {"frame_share", regime.frame_share()},
                   {"best_arm", regime.best_arm()},
                   {"ran_us", JsonIf(regime.has_ran_us(), regime.ran_us())},
                   {"saved_against_single_us",
                    JsonIf(regime.has_saved_against_single_us(), regime.saved_against_single_us())},
                   {"saved_against_reference_us", JsonIf(regime.has_saved_against_reference_us(),
                                                         regime.saved_against_reference_us())},
                   {"saved_against_initial_us", JsonIf(regime.has_saved_against_initial_us(),
                                                       regime.saved_against_initial_us())},
                   {"arms", Json::array()}};
  for (int i = 0; i < std::min(regime.arms_size(), activity.arms_size()); ++i) {
    const v1::RegimeArm& arm = regime.arms(i);
    document["arms"].push_back(
        {{"arm", activity.arms(i)},
         {"cost_us", JsonIf(arm.cost_us() > 0, arm.cost_us())},
         {"cost_us_95", arm.cost_us() > 0 ? Json{arm.low_us(), arm.high_us()} : Json()},
         {"best_probability", arm.best_probability()}});
  }
  return document;
}

}  // namespace

std::string ActivityText(const v1::ScenePosterior& scene) {
  if (!scene.has_activity())
    return "no session is connected; regimes are shown only during a session\n";
  const v1::SceneActivity& activity = scene.activity();
  const uint32_t switch_count = activity.recent_switch_count();
  TextTable table({"regime", "objects", "speed", "static", "frames", "best_arm", "best", "cost_us",
                   "95_low", "95_high", "ran_us", "saved_us"});
  for (int i = 0; i < activity.regimes_size(); ++i) {
    const v1::RegimePosterior& regime = activity.regimes(i);
    table.AddRow(
        RowOf(std::to_string(i + 1) + (regime.is_present() ? " (now)" : ""), regime, activity));
  }
  table.AddRow(RowOf("all", activity.total(), activity));
  return "session " + activity.session_id() + " runs " + activity.active_arm() + " since " +
         UtcText(activity.unix_active_since_ms()) + ", " + std::to_string(switch_count) +
         (switch_count == 1 ? " switch" : " switches") + " in the last minute\n" +
         SavingsText(activity) + table.Text();
}

Json ActivityJson(const v1::ScenePosterior& scene) {
  if (!scene.has_activity()) return {};
  const v1::SceneActivity& activity = scene.activity();
  Json document = {{"session_id", activity.session_id()},
                   {"active_arm", activity.active_arm()},
                   {"initial_arm", activity.initial_arm()},
                   {"unix_active_since_ms", activity.unix_active_since_ms()},
                   {"recent_switches", activity.recent_switch_count()},
                   {"total", RegimeJson(activity.total(), activity)},
                   {"regimes", Json::array()}};
  for (const v1::RegimePosterior& regime : activity.regimes())
    document["regimes"].push_back(RegimeJson(regime, activity));
  return document;
}

}  // namespace sweepstake::cli
