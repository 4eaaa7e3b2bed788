// `sweepstake record`: a scene's frames into a .aabbs file.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddRecordCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
