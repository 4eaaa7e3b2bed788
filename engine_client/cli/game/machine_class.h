// The class of machine whose timings are comparable: system, processor family and number of
// hardware threads, as "linux-x86_64-16". Thread-safe.
#pragma once

#include <string>

namespace sweepstake::cli {

std::string MachineClass();

}  // namespace sweepstake::cli
