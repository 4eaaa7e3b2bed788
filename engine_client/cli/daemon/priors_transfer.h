// Reads a daemon's evidence, and adds to it, through the PriorsService.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/telemetry/embedded/priors_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ImportResult {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
};

// An empty `project` or `scene` selects all. Error: kUnavailable (no daemon answered).
Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene);
// Adds all records or, on an error, none.
Result<ImportResult> ImportPriors(const DaemonOptions& daemon,
                                  std::span<const PriorRecord> records);

}  // namespace sweepstake::cli
