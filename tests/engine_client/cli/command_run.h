// Runs a command line in the test's process and captures its output. This is much faster than
// starting the program. Tests that need a separate process are in program/.
#pragma once

#include <string>

#include "engine_client/cli/commands.h"

namespace sweepstake::cli {

struct CommandRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// Runs `sweepstake`, or the program whose command lines `run` executes. `arguments` are words
// without the program's name, separated by single spaces.
CommandRun RunCommand(const std::string& arguments,
                      int (*run)(std::span<char* const>, Terminal&) = RunCommandLine);

}  // namespace sweepstake::cli
