// How fast the backends mean to be: the goals that ratios are held against. All are for one kind of
// machine and compare within one run.
//
// Pure, safe from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "engine_client/cli/bench/bench_report.h"

namespace sweepstake::cli {

// Bytes at 100,000 objects of suite-b, the pairs included.
inline constexpr double kMemoryGoalBytes = 12e6;

// The goal for a ratio whose `value` alone may still be missing; absent where there is none.
// kFamily, kOverall and kThreads want at least the goal, the others at most.
std::optional<double> GoalOf(const BenchRatio& ratio, const BenchCell& cell);

// Whether `ratio` reaches its goal, or has none.
bool MeetsGoal(const BenchRatio& ratio);

}  // namespace sweepstake::cli
