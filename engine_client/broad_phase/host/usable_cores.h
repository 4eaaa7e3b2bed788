// How many cores the process may use, which can be fewer than the machine has, and can change.
#pragma once

#include <cstddef>

namespace sweepstake {

// The cores of the calling thread's affinity, and not more than the quotas of the process's control
// groups leave (Linux, version 2). At least 1. Thread-safe. System calls, some of them for files.
size_t UsableCores() noexcept;

}  // namespace sweepstake
