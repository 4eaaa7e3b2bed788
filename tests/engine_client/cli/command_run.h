// Runs a command line within the test's process and keeps what it wrote. It is much faster than to
// start the program; what needs a process of its own is in program/.
#pragma once

#include <string>

#include "engine_client/cli/commands.h"

namespace sweepstake::cli {

struct CommandRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// Runs `sweepstake`, or another program by its `run`. `arguments` are words without the program's
// name, separated by single spaces.
CommandRun RunCommand(const std::string& arguments,
                      int (*run)(std::span<char* const>, Terminal&) = RunCommandLine);

}  // namespace sweepstake::cli
