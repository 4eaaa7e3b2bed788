// Speed of the core that a thread runs on, for machines with several kinds of cores.
#pragma once

#include <span>

namespace sweepstake {

// Returns the performance of the calling thread's core relative to the machine's fastest core, in
// (0, 1]. Returns 1 if the system does not report it. Linux reports cpu_capacity or ACPI's
// highest_perf. Thread-safe. The first call reads files; on most machines, later calls make no
// system call.
double CoreSpeed() noexcept;

#if defined(__linux__)

// ACPI ratings above this share of the highest rating count as the same kind of core. Some systems
// rank equal cores by their maximum frequency (AMD: 0.70 or more). Intel's efficiency cores have
// 0.6 or less.
inline constexpr double kOneKind = 0.65;

// Writes the speeds of cores 0, 1, ..., read from the files in `folder`, normally
// /sys/devices/system/cpu. A core without a file gets speed 1.
void ReadCoreSpeeds(const char* folder, std::span<double> speeds) noexcept;

#endif

}  // namespace sweepstake
