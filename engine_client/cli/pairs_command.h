// `sweepstake pairs`: the overlapping pairs of one frame, as one arm finds them.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddPairsCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
