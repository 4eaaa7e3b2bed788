// The comparisons that a bench run is made for, from its rows: arm against peer by family, our best
// against theirs, growth, threads, spikes and memory, each with its goal.
//
// Pure, safe from any thread.
#pragma once

#include <vector>

#include "engine_client/cli/bench/bench_report.h"

namespace sweepstake::cli {

// Of report.cells and report.rows. Rows with a difference count on neither side.
std::vector<BenchRatio> RatiosOf(const BenchReport& report);
std::vector<BenchSpeedup> SpeedupsOf(const BenchReport& report);

}  // namespace sweepstake::cli
