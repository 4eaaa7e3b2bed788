// What `sweepstake bench` found as a page for people: one HTML file with charts and tables, which
// loads nothing. Pure function, safe from any thread; some hundred kilobytes.
#pragma once

#include <string>

#include "engine_client/cli/bench/bench_report.h"

namespace sweepstake::cli {

// `command_line` is shown, `json` (the command's own document, with a "rows" array) is embedded for
// programs.
std::string BenchHtml(const BenchReport& report, const std::string& command_line,
                      const std::string& json);

}  // namespace sweepstake::cli
