// Traces the scenes of an experiment and judges its runs by them (experiment_truth.h), with a
// progress bar. Returns early, and content, when a stop was asked for (stop_signal.h).
#pragma once

#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Makes the traces that are not there yet. The errors of RunTrace and WriteCosts.
Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder, Terminal& terminal);

// Fills in truths and comparisons of the cells that have traces; replays unless a stop was asked
// for. The errors of AssessCell.
Status Assess(const ExperimentFolder& folder, Terminal& terminal, ExperimentReport& report);

}  // namespace sweepstake::cli
