// The parts of the experiment's page that show every live run. Pure functions, safe from any
// thread.
#pragma once

#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// A lane per run: which arm was active when, held-back candidates, bail-outs.
html::Markup SwitchTimelines(const ExperimentReport& report);
// Posterior means over time, a panel per run.
html::Markup PosteriorPanels(const ExperimentReport& report);

}  // namespace sweepstake::cli
