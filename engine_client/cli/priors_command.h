// `sweepstake priors list|export|import`: a daemon's evidence to look at, to ship with a game, and
// to carry elsewhere.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddPriorsCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
