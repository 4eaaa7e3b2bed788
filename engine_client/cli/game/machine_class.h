// Names the class of machines whose timings are comparable by the operating system, the processor
// family and the number of hardware threads, as "linux-x86_64-16". Thread-safe.
#pragma once

#include <string>

namespace sweepstake::cli {

std::string MachineClass();

}  // namespace sweepstake::cli
