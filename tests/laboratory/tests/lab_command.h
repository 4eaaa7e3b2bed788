// Runs a command line of `sweepstake-lab` within the test's process.
#pragma once

#include "tests/engine_client/cli/command_run.h"
#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {

inline CommandRun RunLabCommand(const std::string& arguments) {
  return RunCommand(arguments, RunLaboratory);
}

}  // namespace sweepstake::cli
