// `sweepstake priors doctor`: what of a priors file counts here, and why the rest does not.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine_client/cli/priors/priors_groups.h"

namespace sweepstake::cli {

// Where the file is to be used.
struct PriorsPlace {
  std::string machine_class;
  std::string build;
  uint32_t reward_version = 1;
  ArmVersions arm_versions;
  uint64_t unix_now_s = 0;
};

// kValid: counts as much as what this machine and build measured. kNear: it, or one of its arms,
// counts less. kForeign: counts nothing.
enum class Fitness : uint8_t { kValid, kNear, kForeign };

struct Diagnosed {
  PriorsGroupKey key;
  Fitness fitness = Fitness::kValid;
  double weight = 0;  // of its arms in the versions here, or of others where it has none; at most 1
  std::vector<std::string> reasons;  // why it is not valid, and what else is worth knowing
};

std::vector<Diagnosed> DiagnosePriors(const PriorsGroups& groups, const PriorsPlace& here);

std::string DoctorText(const std::vector<Diagnosed>& diagnosed);
nlohmann::ordered_json DoctorJson(const std::vector<Diagnosed>& diagnosed);

}  // namespace sweepstake::cli
