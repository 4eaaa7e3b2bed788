// The parts of the experiment's page about what is true: how fast each arm is, what policies lose,
// whether live runs and replay agree. Empty where nothing was traced or replayed. Pure functions,
// safe from any thread.
#pragma once

#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

html::Markup TrueRanking(const ExperimentReport& report);
html::Markup RegretCharts(const ExperimentReport& report);
html::Markup LiveAgainstReplay(const ExperimentReport& report);
html::Markup Comparisons(const ExperimentReport& report);

}  // namespace sweepstake::cli
