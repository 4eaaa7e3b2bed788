// `sweepstake replay --log`: derives every decision of an audit log again and says whether it is
// the one in the log.
#pragma once

#include <string>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// The exit code: kDone, all are equal; kCheckFailed, with the first difference; kBadUsage, the file
// cannot be read. Cost: reads the file into memory; some 30 µs a decision of 7 arms.
int ReplayLog(const std::string& file, bool json, Terminal& terminal);

}  // namespace sweepstake::cli
