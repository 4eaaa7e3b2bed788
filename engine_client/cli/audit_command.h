// `sweepstake audit list|export`: a daemon's log of decisions, to look at and to derive again
// (`sweepstake replay --log`).
#pragma once

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

void AddAuditCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
