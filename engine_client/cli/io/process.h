// The main function of a command-line program, and the signals that end the program.
#pragma once

#include <span>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Runs `run` with the standard streams of this process and returns its exit code. If it throws an
// exception, prints the message and returns kCheckFailed.
int RunMain(int argc, char** argv, int (*run)(std::span<char* const> words, Terminal& terminal));

// Catches Ctrl-C and SIGTERM, so that a loop can poll StopRequested. The flag is a static variable,
// the only mutable one of the program, because a signal handler can access nothing else. Call this
// function once.
void InstallStopSignal();
// Returns whether a signal has arrived since InstallStopSignal. A second signal of the same kind
// ends the program at once.
bool StopRequested();

}  // namespace sweepstake::cli
