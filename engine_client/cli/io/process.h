// The process of a command-line program: its main function, and the signals that end it.
#pragma once

#include <span>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Runs `run` on the standard streams of this process and returns its exit code. An exception
// becomes a message and the exit code kCheckFailed.
int RunMain(int argc, char** argv, int (*run)(std::span<char* const> words, Terminal& terminal));

// Records Ctrl-C and SIGTERM, so that a loop can poll for them. The state is the program's only
// mutable static variable, because a signal handler can access no other state. Call it once.
void InstallStopSignal();
// Returns whether a signal was received since InstallStopSignal. A second signal ends the program
// at once.
bool StopRequested();

}  // namespace sweepstake::cli
