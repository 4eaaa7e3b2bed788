// Runs the cells of a bench: every arm with every thread count and every peer on the same frames.
//
// Not thread-safe. Cost: the contestants' own time; a peer exceeds its cap by at most one frame.
// Memory: all contestants of a cell exist at once.
#pragma once

#include <functional>
#include <string>

#include "sweepstake/status.h"
#include "tests/laboratory/bench/bench_report.h"

namespace sweepstake::cli {

// Calls `on_progress` with the share that is done and with what runs. Errors: those of
// UseSimdTarget, ChooseArms and OpenScene. Afterwards the best of the instruction sets that were
// measured is the chosen one. Wrong pairs of an arm or a peer are not an error; its row says so.
Result<BenchReport> RunBench(
    const BenchOptions& options,
    const std::function<void(double share, const std::string& text)>& on_progress);

// Returns whether any row has a difference.
bool AnyDiffers(const BenchReport& report);

}  // namespace sweepstake::cli
