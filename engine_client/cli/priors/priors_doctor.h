// The output of `sweepstake priors doctor`: which evidence of a priors file counts on this machine,
// and why the rest does not.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine_client/decider/pooling/priors_groups.h"

namespace sweepstake::cli {

// The machine, build and program on which the priors file will be used.
struct PriorsPlace {
  std::string machine_class;
  std::string build;
  uint32_t reward_version = 1;
  decision::ArmVersions arm_versions;
  uint64_t unix_now_s = 0;
};

// How much a group of evidence counts.
// - kValid: as much as evidence of this machine and build.
// - kNear: less, or one of its arms counts less.
// - kForeign: not at all.
enum class Fitness : uint8_t { kValid, kNear, kForeign };

struct Diagnosed {
  decision::PriorsGroupKey key;
  Fitness fitness = Fitness::kValid;
  double weight = 0;  // weight of the arms that this program has in the same version or, if there
                      // are none, of its other arms; at most 1
  std::vector<std::string> reasons;  // why it is not valid, and other remarks
};

std::vector<Diagnosed> DiagnosePriors(const decision::PriorsGroups& groups,
                                      const PriorsPlace& here);

std::string DoctorText(const std::vector<Diagnosed>& diagnosed);
nlohmann::ordered_json DoctorJson(const std::vector<Diagnosed>& diagnosed);

}  // namespace sweepstake::cli
