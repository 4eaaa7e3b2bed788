// `sweepstake run`: a scene on the frame path, decided by a daemon, by the embedded decider, or by
// hand.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddRunCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
