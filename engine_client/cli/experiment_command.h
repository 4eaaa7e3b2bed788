// `sweepstake experiment`.
#pragma once

#include <string>

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

// `command_line` goes into the manifest.
void AddExperimentCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                          int& exit_code);

}  // namespace sweepstake::cli
