// `sweepstake replay --log`: derives every decision of an audit log again and compares it with the
// logged one.
#pragma once

#include <string>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Returns the exit code: kDone (all decisions are equal), kCheckFailed (the first difference is
// printed) or kBadUsage (the file cannot be read). The file is read into memory. Cost: some 30 µs
// per decision of 7 arms.
int ReplayLog(const std::string& file, bool json, Terminal& terminal);

}  // namespace sweepstake::cli
