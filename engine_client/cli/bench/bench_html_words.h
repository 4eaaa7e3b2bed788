// How the bench's page says what it says: names, times, verdicts. Pure functions, safe from any
// thread.
#pragma once

#include <string>

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// Milliseconds with three significant digits.
std::string Milliseconds(double ms);
// "14.2×".
std::string Times(double ratio);

// A family's name as people read it.
std::string FamilyTitle(const std::string& family);
// A recording goes by its file's name unless another cell's recording has the same; other scenes by
// their own.
std::string SceneTitle(const BenchReport& report, const BenchCell& cell);
// What moves how in a scene of the project; empty for others.
std::string SceneNote(const std::string& scene);
// "suite-b, 10,000 objects".
std::string CellTitle(const BenchReport& report, size_t cell);
// "SAP", or "SAP (2 threads)".
std::string ContestantTitle(const std::string& name, uint32_t thread_count);

// Whether a ratio of this kind should be large.
bool LargeIsGood(RatioKind kind);
// "✓ met (≥ 5×)" or "✗ missed (≥ 5×)" as a small line; nothing when there is no goal.
html::Markup Verdict(const BenchRatio& ratio);
// The class of a table's cell with that verdict: "met", "missed" or empty.
std::string VerdictClass(const BenchRatio& ratio);

}  // namespace sweepstake::cli
