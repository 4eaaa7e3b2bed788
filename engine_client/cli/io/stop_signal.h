// Records Ctrl-C and SIGTERM, so that a loop can poll for them. The state is the program's only
// mutable static variable, because a signal handler can access no other state. Call
// InstallStopSignal once.
#pragma once

namespace sweepstake::cli {

void InstallStopSignal();
// Returns whether a signal was received since InstallStopSignal. A second signal ends the program
// at once.
bool StopRequested();

}  // namespace sweepstake::cli
