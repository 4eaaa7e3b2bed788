// Groups the records of a priors file by project, scene, build, class of machines and reward
// version. Quarantined records form separate groups. Pure functions.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/pooling/scene_prior.h"

namespace sweepstake::cli {

struct PriorsGroupKey {
  std::string project;
  std::string scene;
  std::string build;
  std::string machine_class;
  uint32_t reward_version = 1;
  bool is_quarantined = false;  // the record is in a daemon's quarantine

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const PriorsGroupKey&, const PriorsGroupKey&) = default;
};

struct PriorsArm {
  uint32_t version = 0;
  decision::ArmEvidence evidence = {};
  uint64_t window_count = 0;
  uint64_t visit_count = 0;
};

using ArmVersions = std::map<std::string, uint32_t>;  // by name

struct PriorsGroup {
  std::map<std::string, PriorsArm> arms;  // by name; only one version of each arm
  std::set<std::string> sources;
  uint64_t last_seen_unix_s = 0;  // 0: unknown
};

using PriorsGroups = std::map<PriorsGroupKey, PriorsGroup>;

PriorsGroupKey GroupOf(const PriorRecord& record);
// Groups the records. For each arm it uses only the evidence of the version in `own` or, if there
// is none, of the latest version.
PriorsGroups GroupPriors(std::span<const PriorRecord> records, const ArmVersions& own = {});

// An arm's cost divided by that of the group's cheapest arm, estimated from the group's evidence
// alone.
struct ArmRatio {
  std::string arm;
  double ratio = 1;
};

// Returns the arms with evidence, the cheapest first. REQUIRES: reward version 3.
std::vector<ArmRatio> CostsOf(const PriorsGroup& group);

// Returns "project/scene", followed by the class of machines, the build and the quarantine if they
// are set.
std::string NameOf(const PriorsGroupKey& key);

}  // namespace sweepstake::cli
