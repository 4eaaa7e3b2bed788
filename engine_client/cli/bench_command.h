// `sweepstake bench`: what each arm costs per frame, on the same frames.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddBenchCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
