// The program `sweepstake`. commands.h lists its commands.
#include "engine_client/cli/commands.h"
#include "engine_client/cli/io/process.h"

int main(int argc, char** argv) {
  return sweepstake::cli::RunMain(argc, argv, sweepstake::cli::RunCommandLine);
}
