// `sweepstake check`: every arm against brute force, every frame, by pair identity.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddCheckCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
