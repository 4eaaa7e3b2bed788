// The machine, the build and the libraries of a bench run. Thread-safe.
#pragma once

#include <span>

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// With Highway among the libraries; `peers` adds their versions and what is absent.
BenchMachine DescribeMachine(std::span<const PeerLibrary> peers);

}  // namespace sweepstake::cli
