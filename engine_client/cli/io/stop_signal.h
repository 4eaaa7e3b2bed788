// Lets a loop ask whether Ctrl-C or SIGTERM was received. A signal handler reaches static variables
// only, so this is the only one of the program. Install it once.
#pragma once

namespace sweepstake::cli {

void InstallStopSignal();
// Returns whether a signal was received since then. A second one ends the program at once.
bool StopRequested();

}  // namespace sweepstake::cli
