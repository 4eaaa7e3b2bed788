// Groups evidence by everything that must agree for a session to use it together: scene, regime,
// machine class, build and reward version. Evidence in quarantine forms separate groups. Pure
// functions.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>

#include "engine_client/decider/pooling/prior_record.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

struct PriorsGroupKey {
  std::string project;
  std::string scene;
  std::string build;
  std::string machine_class;
  uint32_t reward_version = 1;
  bool is_quarantined = false;
  std::string regime = {};  // a bucket (regime_bucket.h)

  // operator<=> is not used, because the std::string of libc++ 14 lacks it.
  friend bool operator<(const PriorsGroupKey& a, const PriorsGroupKey& b) {
    const auto members = [](const PriorsGroupKey& key) {
      return std::tie(key.project, key.scene, key.build, key.machine_class, key.reward_version,
                      key.is_quarantined, key.regime);
    };
    return members(a) < members(b);
  }
  friend bool operator==(const PriorsGroupKey&, const PriorsGroupKey&) = default;
};

struct PriorsArm {
  uint32_t version = 0;
  ArmEvidence evidence = {};
  EvidenceSum pooled = {};  // windows and visits combined (PoolEvidence)
  // The arm's cost ÷ the cost of the group's leader, from the group's evidence alone. Absent if
  // there is no evidence, or if rewards do not depend on the cost alone (log_cost.h).
  std::optional<CostRatio> cost_ratio = {};
};

using ArmVersions = std::map<std::string, uint32_t>;  // backend versions by arm name

struct PriorsGroup {
  std::map<std::string, PriorsArm> arms;  // by name; one version per arm
  std::set<std::string> sources;
  uint64_t last_seen_unix_s = 0;  // 0: unknown
};

using PriorsGroups = std::map<PriorsGroupKey, PriorsGroup>;

PriorsGroupKey GroupOf(const PriorRecord& record);

// Groups the records. Each arm uses its evidence for the version in `own` or, if the group has none
// for that version, for its latest version.
PriorsGroups GroupPriors(std::span<const PriorRecord> records, const ArmVersions& own = {});

}  // namespace sweepstake::decision
