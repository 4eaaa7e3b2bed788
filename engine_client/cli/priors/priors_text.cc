#include "engine_client/cli/priors/priors_text.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/text/counts.h"

namespace sweepstake::cli {
namespace {

using decision::ArmComparison;
using decision::PriorsArm;
using decision::PriorsGroups;
using decision::SceneComparison;
std::string RatioText(const std::optional<PriorsArm>& arm) {
  const std::optional<double> ratio = RatioOf(arm);
  return ratio ? Fixed(*ratio, 2) : "-";
}

// Returns the scenes of the regime, for example ", 545 to 1,096 objects, speed 0.0183 to 0.0498".
std::string RegimeText(const std::string& bucket) {
  const auto range = decision::RangeOf(bucket);
  if (!range) return "";
  const auto& [low, high] = *range;
  std::string text;
  if (low.object_count) {
    const auto least = static_cast<uint64_t>(std::ceil(std::max(*low.object_count, 1.0)));
    const auto most = static_cast<uint64_t>(*high.object_count);
    text += ", " + text::Grouped(least) + " to " + text::Counted(most, "object");
  }
  if (low.speed_mean)
    text += ", speed " + Fixed(*low.speed_mean, 4) + " to " + Fixed(*high.speed_mean, 4);
  if (low.static_ratio) {
    text += ", " + Fixed(100 * std::clamp(*low.static_ratio, 0.0, 1.0), 0) + " to " +
            Percent(std::clamp(*high.static_ratio, 0.0, 1.0), 0) + " static";
  }
  return text;
}

std::string RemarkOn(const SceneComparison& change) {
  if (!change.in_both()) return ": only one of the files has evidence of it";
  return change.leader_changed() ? ": the cheapest arm differs" : "";
}

}  // namespace

std::string NameOf(const decision::PriorsGroupKey& key) {
  std::string name = key.project + "/" + key.scene;
  if (!key.machine_class.empty()) name += " on " + key.machine_class;
  if (!key.build.empty()) name += " in build " + key.build;
  name += RegimeText(key.regime);
  if (key.is_quarantined) name += " (in quarantine)";
  return name;
}

Json KeyJson(const decision::PriorsGroupKey& key) {
  return {{"project", key.project},
          {"scene", key.scene},
          {"regime", key.regime},
          {"build", key.build},
          {"machine_class", key.machine_class},
          {"reward_version", key.reward_version},
          {"quarantined", key.is_quarantined}};
}

std::string ShowText(const PriorsGroups& groups) {
  TextTable table({"arm", "version", "windows", "visits", "bail-outs", "cost ratio"});
  for (const auto& [key, group] : groups) {
    table.AddTitle(NameOf(key) + ", " + text::Counted(group.sources.size(), "source"));
    for (const auto& [name, arm] : group.arms)
      table.AddRow({name, std::to_string(arm.version), text::Grouped(arm.evidence.window_count),
                    text::Grouped(arm.evidence.visit_count),
                    text::Grouped(arm.evidence.bail_out_count), RatioText(arm)});
  }
  return table.Text();
}

Json ShowJson(const PriorsGroups& groups) {
  Json entries = Json::array();
  for (const auto& [key, group] : groups) {
    Json arms = Json::array();
    for (const auto& [name, arm] : group.arms) {
      arms.push_back({{"arm", name},
                      {"backend_version", arm.version},
                      {"windows", arm.evidence.window_count},
                      {"visits", arm.evidence.visit_count},
                      {"bail_outs", arm.evidence.bail_out_count},
                      {"cost_ratio", OrNull(RatioOf(arm))}});
    }
    Json& entry = entries.emplace_back(KeyJson(key));
    entry["sources"] = group.sources.size();
    entry["arms"] = std::move(arms);
  }
  return entries;
}

std::string DiffText(const std::vector<SceneComparison>& changes) {
  if (changes.empty()) return "The files agree on every scene to within 5 %.\n";
  TextTable table({"arm", "cost before", "after"});
  for (const SceneComparison& change : changes) {
    table.AddTitle(NameOf(change.key) + RemarkOn(change));
    for (const ArmComparison& arm : change.arms)
      table.AddRow({arm.arm, RatioText(arm.before), RatioText(arm.after)});
  }
  return table.Text();
}

Json DiffJson(const std::vector<SceneComparison>& changes) {
  Json entries = Json::array();
  for (const SceneComparison& change : changes) {
    Json arms = Json::array();
    for (const ArmComparison& arm : change.arms)
      arms.push_back({{"arm", arm.arm},
                      {"before", OrNull(RatioOf(arm.before))},
                      {"after", OrNull(RatioOf(arm.after))}});
    entries.push_back({{"project", change.key.project},
                       {"scene", change.key.scene},
                       {"regime", change.key.regime},
                       {"machine_class", change.key.machine_class},
                       {"leader_changed", change.leader_changed()},
                       {"arms", arms}});
  }
  return entries;
}

}  // namespace sweepstake::cli
