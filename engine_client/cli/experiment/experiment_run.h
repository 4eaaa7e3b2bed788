// Runs an experiment: traces the scenes, plays the runs that are missing, and judges them by the
// traces. Each trace and each run is on disk as soon as it ends. All functions return early,
// without an error, when a stop was asked for (stop_signal.h), and show a progress bar.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_plan.h"
#include "engine_client/cli/experiment/experiment_truth.h"
#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// "1 h 12 min", "3 min", "40 s".
std::string DurationText(uint64_t ns);

// Makes the traces that are missing. The errors of RunTrace and WriteCosts.
Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder, Terminal& terminal);

// Plays the runs that are missing. The errors of PlayLive and of writing.
Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder, Terminal& terminal);

// The truths of the cells that have traces, with comparisons; without replays after a stop. The
// errors of AssessCell.
Result<ExperimentTruths> Assess(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                std::span<const CellSummary> cells, Terminal& terminal);

}  // namespace sweepstake::cli
