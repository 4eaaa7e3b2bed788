// `sweepstake watch`: the daemon's posteriors and decisions, live.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddWatchCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
