// Returns a name for the class of this machine. Timings of machines of one class are comparable.
#pragma once

#include <string>

#include "sweepstake/names/begin.h"

namespace sweepstake {

// Returns a name made of these parts:
// - the processor
// - the hardware threads that the process may use
// - the instruction set of the broad phases
// - the memory in GiB, rounded up to a multiple of four
// For example "amd-epyc-7763-64-core-16-avx2-64g". Parts that the system does not report are left
// out. The name has at most 128 bytes. Processes that may use the same number of threads get the
// same name. Cost: reads files. Any thread.
std::string MachineClass();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
