// The name of the processor, as text.
#pragma once

#include <string>

namespace sweepstake {

// Returns the name that the processor or the system reports, such as "AMD EPYC 7763 64-Core
// Processor". On Arm under Linux this is "arm" and, if it can be read, the main identification
// register. Empty if nothing is reported. May read a file. Any thread.
std::string ProcessorName();

}  // namespace sweepstake
