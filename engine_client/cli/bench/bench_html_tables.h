// The tables of the bench's page. Pure functions, safe from any thread.
#pragma once

#include "engine_client/cli/bench/bench_html_index.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// Per cell the best of ours against the best peer. REQUIRES: a kOverall ratio.
html::Markup OverallTable(const BenchIndex& index);
// Per cell who was fastest: for a run without peers.
html::Markup FastestTable(const BenchIndex& index);
// Per kind of goal how many were met, and which were missed. Empty when there are no goals.
html::Markup GoalsTable(const BenchIndex& index);
// Each of our arms against the best peer of its family. REQUIRES: a kFamily ratio.
html::Markup FamilyTable(const BenchIndex& index);

// Contestants against cells: milliseconds, time per object, the slowest frames, AABB checks,
// memory.
html::Markup TimeTable(const BenchIndex& index);
html::Markup GrowthTable(const BenchIndex& index);
html::Markup SpikeTable(const BenchIndex& index);
html::Markup CheckTable(const BenchIndex& index);
html::Markup MemoryTable(const BenchIndex& index);
// Speed-up by threads. REQUIRES: ours were run with more than one number of threads.
html::Markup ThreadTable(const BenchIndex& index);

// Every row as it was measured, those that took no part too.
html::Markup RowTable(const BenchIndex& index);

}  // namespace sweepstake::cli
