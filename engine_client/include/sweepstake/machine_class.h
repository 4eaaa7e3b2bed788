// Machines whose timings compare.
#pragma once

#include <string>

#include "sweepstake/names/begin.h"

namespace sweepstake {

// Names this machine by its processor, the hardware threads that the process may use, the
// instruction set that the broad phases run with and the memory in GiB, rounded up to a multiple of
// four: "amd-epyc-7763-64-core-16-avx2-64g". What the system does not tell is left out. A name of
// at most 128 bytes, the same in each process that may use as many threads. Reads files; any
// thread.
std::string MachineClass();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
