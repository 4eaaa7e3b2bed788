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

// Calls `on_progress` with the finished share and the name of the current cell. Afterwards the best
// measured instruction set is the chosen one. If an arm or a peer finds wrong pairs, its row
// contains the difference; this is not an error. Errors: those of UseSimdTarget, ChooseArms and
// OpenScene.
Result<BenchReport> RunBench(
    const BenchOptions& options,
    const std::function<void(double share, const std::string& text)>& on_progress);

// Returns whether any row has a difference.
bool AnyDiffers(const BenchReport& report);

}  // namespace sweepstake::cli
