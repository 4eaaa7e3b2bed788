// The charts of the bench's page: time against the number of objects, one per scene. A scene with
// one number of objects shows its contestants one below the other instead. Pure function, safe from
// any thread.
#pragma once

#include "engine_client/cli/bench/bench_html_index.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

html::Markup TimeCharts(const BenchIndex& index);

}  // namespace sweepstake::cli
