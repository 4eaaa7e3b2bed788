// `sweepstake replay`: policies play recorded cost traces in virtual time.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddReplayCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
