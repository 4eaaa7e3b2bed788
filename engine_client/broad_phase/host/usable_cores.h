// The number of cores that the process may use. It can be lower than the machine's number of cores,
// and it can change.
#pragma once

#include <cstddef>

namespace sweepstake {

// Returns the number of cores in the calling thread's affinity mask, limited by the quotas of the
// process's control groups (Linux, version 2). At least 1. Thread-safe. Makes system calls and may
// read files.
size_t UsableCores() noexcept;

}  // namespace sweepstake
