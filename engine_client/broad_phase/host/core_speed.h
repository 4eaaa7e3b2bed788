// How fast the core is that a thread runs on, where a machine has cores of several kinds.
#pragma once

#include <span>

namespace sweepstake {

// The performance of the core that the calling thread is on ÷ that of the machine's fastest one, in
// (0, 1]; 1 where the system does not tell. Linux does, as cpu_capacity or, of ACPI, highest_perf.
// Thread-safe. The first call reads files; on most machines, later ones make no system call.
double CoreSpeed() noexcept;

#if defined(__linux__)

// ACPI's ratings above this share of the highest one are of one kind of core: some systems rank
// those by the frequency that each may reach. (AMD: 0.70 and more; Intel's two kinds: 0.6 or less.)
inline constexpr double kOneKind = 0.65;

// The same of cores 0, 1, ... by the files in `folder`, which is /sys/devices/system/cpu. Cores
// without a file count as fast.
void ReadCoreSpeeds(const char* folder, std::span<double> speeds) noexcept;

#endif

}  // namespace sweepstake
