// `sweepstake trace`: the cost of every arm on every frame of a scene, as a file.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddTraceCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
