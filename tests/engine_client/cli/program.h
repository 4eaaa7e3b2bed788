// Runs the real program `sweepstake` and keeps what it wrote.
#pragma once

#include <string>

namespace sweepstake::cli {

struct ProgramRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

// `arguments` is a line for the shell.
ProgramRun RunProgram(const std::string& arguments);

// The same with `sweepstaked`.
ProgramRun RunDaemonProgram(const std::string& arguments);

// A path for a file of this test process that no other one uses.
std::string TemporaryPath(const std::string& name);

}  // namespace sweepstake::cli
