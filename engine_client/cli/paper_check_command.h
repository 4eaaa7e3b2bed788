// `sweepstake paper-check`: the paper's Table 4 against the policy `paper`.
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddPaperCheckCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
