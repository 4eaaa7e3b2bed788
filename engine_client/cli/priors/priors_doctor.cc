#include "engine_client/cli/priors/priors_doctor.h"

#include <algorithm>
#include <array>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/priors/priors_text.h"
#include "engine_client/decider/pooling/source_prior.h"
#include "engine_client/decider/session/policy_registry.h"

namespace sweepstake::cli {
namespace {

using decision::PriorsGroup;
using decision::PriorsGroupKey;
using decision::PriorsGroups;

constexpr uint64_t kDayS = 86'400;
constexpr uint64_t kOldDays = 180;

std::string OrUnknown(const std::string& name) { return name.empty() ? "unknown" : name; }

// The text of each Fitness, indexed by value.
constexpr std::array<const char*, 3> kFitnessNames = {"valid", "near", "foreign"};

const char* WordOf(Fitness fitness) { return kFitnessNames[static_cast<size_t>(fitness)]; }

// Returns the weight of evidence, as a fraction of the weight of evidence that this machine and
// build measured with the same version of the arm.
double WeightOf(decision::SourceRelation relation, bool same_arm_version) {
  relation.same_backend_version = same_arm_version;
  return decision::PowerPriorWeight(relation) /
         decision::PowerPriorWeight({.same_build = true, .same_machine_class = true});
}

// Returns the weight in percent. Below 1 % it has a decimal, because "0 %" would mean that the
// evidence does not count.
std::string WeightText(double weight) {
  return Percent(weight, 0 < weight && weight < 0.01 ? 1 : 0);
}

// Returns how many of the group's arms this program has in the same version. Adds a reason to
// `found` for each other arm. `other_weight` is the weight of an arm in another version.
size_t CountSameArms(const PriorsGroup& group, const PriorsPlace& here, double other_weight,
                     Diagnosed& found) {
  size_t same = 0;
  for (const auto& [name, arm] : group.arms) {
    const auto known = here.arm_versions.find(name);
    if (known == here.arm_versions.end()) {
      found.reasons.push_back("there is no arm " + name + " here");
    } else if (known->second != arm.version) {
      found.reasons.push_back(name + " has version " + std::to_string(arm.version) +
                              " (this program: " + std::to_string(known->second) + ")" +
                              (other_weight > 0 ? ", and counts " + WeightText(other_weight) : ""));
    } else {
      ++same;
    }
  }
  return same;
}

// Returns who learnt evidence with this version of rewards.
std::string RewardText(uint32_t version) {
  for (const decision::PolicyEntry& entry : decision::ShippedPolicies()) {
    if (entry.kind.reward_version == version)
      return "learnt by the policy " + std::string(entry.kind.name);
  }
  if (version >= decision::kFirstOwnRewardVersion) return "learnt with other reward weights";
  return "its reward has version " + std::to_string(version);
}

Diagnosed Diagnose(const PriorsGroupKey& key, const PriorsGroup& group, const PriorsPlace& here) {
  Diagnosed found{.key = key, .reasons = {}};
  const decision::SourceRelation relation{
      .same_build = key.build == here.build,
      .same_machine_class = key.machine_class == here.machine_class};
  if (!relation.same_machine_class)
    found.reasons.push_back("measured on " + OrUnknown(key.machine_class) + ", this machine is " +
                            OrUnknown(here.machine_class));
  if (key.build != here.build) found.reasons.push_back("measured by build " + OrUnknown(key.build));
  const bool may_count = key.reward_version == here.reward_version && !key.is_quarantined;
  const size_t same = CountSameArms(
      group, here, may_count ? WeightOf(relation, /*same_arm_version=*/false) : 0, found);
  if (group.last_seen_unix_s > 0 && here.unix_now_s > group.last_seen_unix_s) {
    const uint64_t days = (here.unix_now_s - group.last_seen_unix_s) / kDayS;
    if (days > kOldDays)
      found.reasons.push_back(std::to_string(days) + " days old, which does not reduce its weight");
  }
  found.weight = WeightOf(relation, same > 0);
  if (key.reward_version != here.reward_version) {
    found.reasons.insert(found.reasons.begin(),
                         RewardText(key.reward_version) + ", which the default policy cannot use");
    found.weight = 0;
  }
  const bool knows_any = std::any_of(group.arms.begin(), group.arms.end(), [&](const auto& arm) {
    return here.arm_versions.contains(arm.first);
  });
  if (!knows_any) found.weight = 0;
  if (key.is_quarantined) {
    found.reasons.insert(found.reasons.begin(),
                         "it is in quarantine, and counts after it is promoted and exported again");
    found.weight = 0;
  }
  const bool whole = found.weight == 1 && same == group.arms.size();
  found.fitness = found.weight == 0 ? Fitness::kForeign : whole ? Fitness::kValid : Fitness::kNear;
  return found;
}

}  // namespace

std::vector<Diagnosed> DiagnosePriors(const PriorsGroups& groups, const PriorsPlace& here) {
  std::vector<Diagnosed> diagnosed;
  for (const auto& [key, group] : groups) diagnosed.push_back(Diagnose(key, group, here));
  return diagnosed;
}

std::string DoctorText(const std::vector<Diagnosed>& diagnosed) {
  TextTable table({"scene", "here", "counts", "why"});
  for (const Diagnosed& one : diagnosed) {
    std::string why;
    for (const std::string& reason : one.reasons) why += (why.empty() ? "" : "; ") + reason;
    table.AddRow({NameOf(one.key), WordOf(one.fitness), WeightText(one.weight), why});
  }
  return table.Text();
}

Json DoctorJson(const std::vector<Diagnosed>& diagnosed) {
  Json entries = Json::array();
  for (const Diagnosed& one : diagnosed) {
    Json& entry = entries.emplace_back(KeyJson(one.key));
    entry["fitness"] = WordOf(one.fitness);
    entry["weight"] = one.weight;
    entry["reasons"] = one.reasons;
  }
  return entries;
}

}  // namespace sweepstake::cli
