// Ctrl-C and SIGTERM as a question to ask between frames. A signal handler reaches only what is
// static, so this is the one piece of state of the program that is; install it once.
#pragma once

namespace sweepstake::cli {

void InstallStopSignal();
// Whether a stop was asked for since then. A second Ctrl-C ends the program at once.
bool StopRequested();

}  // namespace sweepstake::cli
