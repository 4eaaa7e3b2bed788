// What the processor calls itself.
#pragma once

#include <string>

namespace sweepstake {

// The name as the processor or the system has it, "AMD EPYC 7763 64-Core Processor"; of an Arm
// processor under Linux its main identification register; "arm" where nothing tells. Reads files at
// most; any thread.
std::string ProcessorName();

}  // namespace sweepstake
