// The main function of a command-line program, and the signals that end the program.
#pragma once

#include <span>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

// Runs `run` with the standard streams of this process and returns its exit code. If it throws an
// exception, prints the message and returns kCheckFailed.
int RunMain(int argc, char** argv, int (*run)(std::span<char* const> words, Terminal& terminal));

// Catches Ctrl-C and SIGTERM, so that a loop can poll StopRequested. The flags of this file are the
// only mutable static variables of the program, because a signal handler can access nothing else.
// Call this function once.
void InstallStopSignal();
// Returns whether a signal has arrived since InstallStopSignal. A second signal of the same kind
// ends the program at once.
bool StopRequested();

// Catches Ctrl-Z (SIGTSTP), so that a loop can poll SuspendRequested and then restore the terminal
// before it calls Suspend.
void CatchSuspendSignal();
// Returns whether Ctrl-Z has arrived since CatchSuspendSignal or the end of the latest Suspend.
bool SuspendRequested();
// Stops this process as Ctrl-Z does if it is not caught. Returns when the process continues
// (SIGCONT), or at once if no shell could continue it. REQUIRES: CatchSuspendSignal was called.
void Suspend();
// Ends CatchSuspendSignal. If Ctrl-Z has arrived, suspends first.
void ReleaseSuspendSignal();

}  // namespace sweepstake::cli
