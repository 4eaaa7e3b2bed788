// The program `sweepstaked`. program.h describes its exit codes.
#include "server/program.h"

// NOLINTNEXTLINE(bugprone-exception-escape): only running out of memory, which may end the program.
int main(int argc, char** argv) { return sweepstake::server::RunProgram(argc, argv); }
