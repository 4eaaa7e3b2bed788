// How many cores the process may use, which can be fewer than the machine has, and can change; and
// of what kind the present one is.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sweepstake {

// The cores of the calling thread's affinity, and not more than the quotas of the process's control
// groups leave (Linux, version 2). At least 1. Thread-safe. System calls, some of them for files.
size_t UsableCores() noexcept;

// What cores that are as fast as the calling thread's present one have in common, and others do not
// (Linux: the capacity of ARM's, whether it is one of Intel's efficient ones). The same for all
// cores where the system does not tell. Thread-safe. System calls, some of them for files.
uint32_t CoreKind() noexcept;

// Returns whether a list of ranges such as "0-3,8" has the number. A list ends where it is broken.
bool IsInRanges(const char* list, unsigned number) noexcept;

}  // namespace sweepstake
