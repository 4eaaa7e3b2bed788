// The main function of a command-line program.
#pragma once

#include <span>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Runs `run` on the standard streams of this process and returns its exit code. An exception
// becomes a message and the exit code kCheckFailed.
int RunMain(int argc, char** argv, int (*run)(std::span<char* const> words, Terminal& terminal));

}  // namespace sweepstake::cli
