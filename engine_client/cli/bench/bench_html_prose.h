// What the bench's page says in words: the headline, the machine, how it was measured, what the
// columns mean. Pure functions, safe from any thread.
#pragma once

#include <string>

#include "engine_client/cli/bench/bench_html_index.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// What this page is, for somebody who has never seen one, and when and where it was made.
html::Markup Introduction(const BenchReport& report);
// How many times faster the best of ours is than the best peer, over all cells; without peers, that
// there were none.
html::Markup Headline(const BenchIndex& index);
// What to know before believing the numbers: wrong pairs, and who was left out. May be empty.
html::Markup Warnings(const BenchReport& report);
html::Markup MachineList(const BenchReport& report, const std::string& command_line);
html::Markup Method(const BenchReport& report);
html::Markup Terms();

}  // namespace sweepstake::cli
