// The raw rows of an experiment as CSV files, all runs in each: activations, switches, decisions,
// posteriors (of all arms, over time), metrics (thinned), controls, time. Each row names its run.
#pragma once

#include <filesystem>
#include <span>

#include "engine_client/cli/experiment/experiment_record.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// In `folder`, which exists. The errors of CsvFile.
Status WriteRawCsv(std::span<const RunRecord> records, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
