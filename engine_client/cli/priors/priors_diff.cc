#include "engine_client/cli/priors/priors_diff.h"

#include <algorithm>
#include <cmath>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;
using Ratios = std::map<std::string, double>;  // by arm

constexpr double kChange = 0.05;

bool IsCompared(const PriorsGroupKey& key) {
  return key.reward_version == decision::kLogCostRewardVersion;
}

Ratios RatiosOf(const PriorsGroupKey& key, const PriorsGroup& group) {
  Ratios ratios;
  if (!IsCompared(key)) return ratios;
  for (const ArmRatio& cost : CostsOf(group)) ratios[cost.arm] = cost.ratio;
  return ratios;
}

std::map<PriorsGroupKey, Ratios> RatiosOf(const PriorsGroups& groups) {
  std::map<PriorsGroupKey, Ratios> all;
  for (const auto& [key, group] : groups) {
    if (IsCompared(key)) all[key] = RatiosOf(key, group);
  }
  return all;
}

std::optional<double> RatioIn(const Ratios& ratios, const std::string& arm) {
  const auto found = ratios.find(arm);
  return found == ratios.end() ? std::nullopt : std::optional(found->second);
}

bool IsChange(const ArmChange& arm) {
  if (!arm.before || !arm.after) return arm.before.has_value() != arm.after.has_value();
  return std::abs(std::log(*arm.after / *arm.before)) > kChange;
}

GroupChange Compare(const PriorsGroupKey& key, const Ratios& before, const Ratios& after) {
  GroupChange change{.key = key, .arms = {}};
  Ratios all = before;
  all.insert(after.begin(), after.end());
  for (const auto& [arm, ratio] : all)
    change.arms.push_back({arm, RatioIn(before, arm), RatioIn(after, arm)});
  return change;
}

std::string RemarkOn(const GroupChange& change) {
  if (!change.in_both()) return ": only one of the files has evidence of it";
  return change.leader_changed() ? ": the cheapest arm differs" : "";
}

std::string RatioText(const std::optional<double>& ratio) { return ratio ? Fixed(*ratio, 2) : "-"; }

}  // namespace

bool GroupChange::in_both() const {
  const auto any = [&](std::optional<double> ArmChange::*ratio) {
    return std::any_of(arms.begin(), arms.end(),
                       [&](const ArmChange& arm) { return (arm.*ratio).has_value(); });
  };
  return any(&ArmChange::before) && any(&ArmChange::after);
}

bool GroupChange::leader_changed() const {
  return in_both() && std::none_of(arms.begin(), arms.end(), [](const ArmChange& arm) {
           return arm.before && arm.after && *arm.before == 1 && *arm.after == 1;
         });
}

std::string ShowText(const PriorsGroups& groups) {
  TextTable table({"arm", "version", "windows", "visits", "bail-outs", "cost ratio"});
  for (const auto& [key, group] : groups) {
    table.AddTitle(NameOf(key) + ", " + std::to_string(group.sources.size()) + " sources");
    const Ratios ratios = RatiosOf(key, group);
    for (const auto& [name, arm] : group.arms)
      table.AddRow({name, std::to_string(arm.version), Grouped(arm.window_count),
                    Grouped(arm.visit_count), Grouped(arm.evidence.bail_out_count),
                    RatioText(RatioIn(ratios, name))});
  }
  return table.Text();
}

Json ShowJson(const PriorsGroups& groups) {
  Json entries = Json::array();
  for (const auto& [key, group] : groups) {
    const Ratios ratios = RatiosOf(key, group);
    Json arms = Json::array();
    for (const auto& [name, arm] : group.arms) {
      arms.push_back({{"arm", name},
                      {"backend_version", arm.version},
                      {"windows", arm.window_count},
                      {"visits", arm.visit_count},
                      {"bail_outs", arm.evidence.bail_out_count},
                      {"cost_ratio", OrNull(RatioIn(ratios, name))}});
    }
    entries.push_back({{"project", key.project},
                       {"scene", key.scene},
                       {"build", key.build},
                       {"machine_class", key.machine_class},
                       {"reward_version", key.reward_version},
                       {"quarantined", key.is_quarantined},
                       {"sources", group.sources.size()},
                       {"arms", arms}});
  }
  return entries;
}

std::vector<GroupChange> DiffPriors(const PriorsGroups& before, const PriorsGroups& after) {
  const auto old_ratios = RatiosOf(before);
  auto all = RatiosOf(after);
  std::vector<GroupChange> changes;
  for (const auto& [key, ratios] : old_ratios) all.try_emplace(key);
  for (const auto& [key, ratios] : all) {
    const auto old = old_ratios.find(key);
    GroupChange change = Compare(key, old == old_ratios.end() ? Ratios() : old->second, ratios);
    if (std::any_of(change.arms.begin(), change.arms.end(), IsChange))
      changes.push_back(std::move(change));
  }
  return changes;
}

std::string DiffText(const std::vector<GroupChange>& changes) {
  if (changes.empty()) return "The files agree on every scene to within 5 %.\n";
  TextTable table({"arm", "cost before", "after"});
  for (const GroupChange& change : changes) {
    table.AddTitle(NameOf(change.key) + RemarkOn(change));
    for (const ArmChange& arm : change.arms)
      table.AddRow({arm.arm, RatioText(arm.before), RatioText(arm.after)});
  }
  return table.Text();
}

Json DiffJson(const std::vector<GroupChange>& changes) {
  Json entries = Json::array();
  for (const GroupChange& change : changes) {
    Json arms = Json::array();
    for (const ArmChange& arm : change.arms)
      arms.push_back(
          {{"arm", arm.arm}, {"before", OrNull(arm.before)}, {"after", OrNull(arm.after)}});
    entries.push_back({{"project", change.key.project},
                       {"scene", change.key.scene},
                       {"machine_class", change.key.machine_class},
                       {"leader_changed", change.leader_changed()},
                       {"arms", arms}});
  }
  return entries;
}

}  // namespace sweepstake::cli
