// Runs a command line of `sweepstake` within the test's process and keeps what it wrote. It is much
// faster than to start the program; what needs a process of its own is in program/.
#pragma once

#include <string>

namespace sweepstake::cli {

struct CommandRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// `arguments` are words without the program's name, separated by single spaces.
CommandRun RunCommand(const std::string& arguments);

}  // namespace sweepstake::cli
