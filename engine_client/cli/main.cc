// The program `sweepstake`. Its commands are listed in commands.h.
#include "engine_client/cli/commands.h"
#include "engine_client/cli/io/process.h"

int main(int argc, char** argv) {
  return sweepstake::cli::RunMain(argc, argv, sweepstake::cli::RunCommandLine);
}
