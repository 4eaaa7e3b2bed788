// Names classes of machines whose timings are comparable.
#pragma once

#include <string>

#include "sweepstake/names/begin.h"

namespace sweepstake {

// Returns a name for this machine. Its parts are the processor, the hardware threads that the
// process may use, the instruction set of the broad phases, and the memory. Memory is in GiB,
// rounded up to a multiple of four. Example: "amd-epyc-7763-64-core-16-avx2-64g". Parts that the
// system does not report are left out. At most 128 bytes; the same in each process that may use the
// same number of threads. Reads files; any thread.
std::string MachineClass();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
