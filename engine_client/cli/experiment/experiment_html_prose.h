// The experiment's page in words: what was done, what came out, what the words mean. Pure
// functions, safe from any thread.
#pragma once

#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

html::Markup ExperimentLead(const ExperimentReport& report);
html::Markup ExperimentSummary(const ExperimentReport& report);
html::Markup ExperimentMethod(const ExperimentReport& report);
html::Markup ExperimentTerms();
html::Markup ExperimentManifestList(const ExperimentReport& report);

}  // namespace sweepstake::cli
