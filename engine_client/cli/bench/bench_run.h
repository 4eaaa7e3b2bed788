// Runs the cells of a bench: every arm with every thread count and every peer on the same frames.
//
// Not thread-safe. Cost: the contestants' own time; a peer exceeds its cap by at most one frame.
// Memory: all contestants of a cell exist at once.
#pragma once

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/io/terminal.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Shows its progress on `terminal`. Errors: those of ChooseArms and OpenScene. Wrong pairs of an
// arm or a peer are not an error; its row says so.
Result<BenchReport> RunBench(const BenchOptions& options, Terminal& terminal);

// Returns whether any row has a difference.
bool AnyDiffers(const BenchReport& report);

}  // namespace sweepstake::cli
