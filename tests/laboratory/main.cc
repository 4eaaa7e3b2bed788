// The program `sweepstake-lab`. laboratory.h lists its commands.
#include "engine_client/cli/io/process.h"
#include "tests/laboratory/laboratory.h"

int main(int argc, char** argv) {
  return sweepstake::cli::RunMain(argc, argv, sweepstake::cli::RunLaboratory);
}
