// Evidence between a daemon and memory, over the PriorsService.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine_client/telemetry/priors_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ImportResult {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
};

// Empty `project` or `scene`: all. kUnavailable: no daemon answered.
Result<std::vector<PriorRecord>> ExportPriors(const std::string& address,
                                              const std::string& project, const std::string& scene);
// All records or, on an error, none.
Result<ImportResult> ImportPriors(const std::string& address, std::span<const PriorRecord> records);

}  // namespace sweepstake::cli
