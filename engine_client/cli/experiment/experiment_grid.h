// Plays the runs of an experiment that are not there yet, each onto the disk as it ends.
#pragma once

#include <cstdint>
#include <vector>

#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_plan.h"
#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// "1 h 12 min", "3 min", "40 s".
std::string DurationText(uint64_t ns);

// Shows a bar over the whole grid with the time left. Returns early, and content, when a stop was
// asked for (stop_signal.h). The errors of PlayLive and of writing.
Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder, Terminal& terminal);

}  // namespace sweepstake::cli
