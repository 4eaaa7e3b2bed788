// Prints a bench report as one JSON document or as text tables. Only the stream is changed.
#pragma once

#include <ostream>

#include "tests/laboratory/bench/bench_report.h"

namespace sweepstake::cli {

void PrintBenchJson(const BenchReport& report, std::ostream& out);

// Prints the rows and then the ratios, if there are any.
void PrintBenchTables(const BenchReport& report, std::ostream& out);

}  // namespace sweepstake::cli
