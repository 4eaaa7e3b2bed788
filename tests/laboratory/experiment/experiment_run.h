// Runs an experiment: traces the scenes, plays the missing runs, and judges them by the traces.
// Each trace and each run is written to disk when it ends. All functions call `on_progress` with
// the finished share and the name of the current cell or run. They return early, without an error,
// if a stop was requested (stop_signal.h).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_folder.h"
#include "tests/laboratory/experiment/experiment_plan.h"
#include "tests/laboratory/experiment/experiment_truth.h"

namespace sweepstake::cli {

// Returns "1 h 12 min", "3 min" or "40 s".
std::string DurationText(uint64_t ns);

using ExperimentProgress = std::function<void(double share, const std::string& text)>;

// Makes the missing traces. Errors: those of RunTrace and WriteCosts.
Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder,
                  const ExperimentProgress& on_progress);

// Plays the missing runs. Errors: those of PlayLive and of writing.
Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder,
                const ExperimentProgress& on_progress);

// Returns the truths of the cells that have traces, with comparisons, but without replays after a
// stop. Errors: those of AssessCell.
Result<ExperimentTruths> Assess(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                std::span<const CellSummary> cells,
                                const ExperimentProgress& on_progress);

}  // namespace sweepstake::cli
