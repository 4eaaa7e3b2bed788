// The parts of the experiment's page that say something of each cell's live runs. Pure functions,
// safe from any thread.
#pragma once

#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// Scenario × size: which arm dominated.
html::Markup DominanceGrid(const ExperimentReport& report);
// Tables 3 and 4, the paper's figures beside.
html::Markup PaperTables(const ExperimentReport& report);
html::Markup ActiveShares(const ExperimentReport& report);
html::Markup VerdictShares(const ExperimentReport& report);
html::Markup TimeParts(const ExperimentReport& report);

}  // namespace sweepstake::cli
