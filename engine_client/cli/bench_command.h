// `sweepstake bench`: what each arm costs per frame, on the same frames.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

// `command_line` is shown in the page of --report.
void AddBenchCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                     int& exit_code);

}  // namespace sweepstake::cli
