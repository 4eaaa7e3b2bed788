// A bench report as one JSON document and as tables for people. Pure but for the stream.
#pragma once

#include <ostream>

#include "engine_client/cli/bench/bench_report.h"

namespace sweepstake::cli {

void PrintBenchJson(const BenchReport& report, std::ostream& out);

// The rows, then, where there are any, the ratios.
void PrintBenchTables(const BenchReport& report, std::ostream& out);

}  // namespace sweepstake::cli
