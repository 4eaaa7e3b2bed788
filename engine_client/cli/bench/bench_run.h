// Runs the cells of a bench: every arm with every count of threads, and every peer, through the
// same frames.
//
// Not thread-safe. Cost: what the contestants take, and a peer at most its cap by more than one
// frame. Memory: all contestants of a cell at once.
#pragma once

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Shows its progress on `terminal`. The errors of ChooseArms and OpenScene; a peer or an arm whose
// pairs are wrong is no error but in its row.
Result<BenchReport> RunBench(const BenchOptions& options, Terminal& terminal);

// Whether any row has a difference.
bool AnyDiffers(const BenchReport& report);

}  // namespace sweepstake::cli
