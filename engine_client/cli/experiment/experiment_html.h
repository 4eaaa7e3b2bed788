// What `sweepstake experiment` found as a page for people: one HTML file with charts and tables,
// which loads nothing. Pure function, safe from any thread; some megabytes for the whole grid.
#pragma once

#include <string>

#include "engine_client/cli/experiment/experiment_report.h"

namespace sweepstake::cli {

// `json` (the command's own document) is embedded for programs. REQUIRES: a sitting.
std::string ExperimentHtml(const ExperimentReport& report, const std::string& json);

}  // namespace sweepstake::cli
