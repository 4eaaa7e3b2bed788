#pragma once

namespace sweepstake::server {

// The whole of `sweepstaked`: reads the configuration, runs the daemon until SIGTERM or SIGINT,
// then drains it. SIGHUP makes it read the configuration again. Returns the exit code, or ends
// the process with it: 0 done; 1 a subcommand failed; 2 bad usage or configuration; 3 the daemon
// could not start; 4 the daemon did not end within nine seconds after a signal, or after copying a
// database whose file was removed.
int RunProgram(int argc, char** argv);

}  // namespace sweepstake::server
