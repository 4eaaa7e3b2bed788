// How fast the core is that a thread runs on, where a machine has cores of several kinds.
#pragma once

#include <cstddef>
#include <span>

namespace sweepstake {

// Cores that the system rates within this of the fastest one count as fast: it also ranks cores of
// one kind by how high they clock.
inline constexpr double kOneKind = 0.75;

// The performance of the core that the calling thread is on ÷ that of the machine's fastest one, in
// (0, 1]; 1 where the system does not tell. Linux does, as cpu_capacity or, of ACPI, highest_perf.
// Thread-safe. The first call reads files; later ones cost less than a system call on most
// machines.
double CoreSpeed() noexcept;

// The same of cores 0, 1, ... by the files in `folder`, which is /sys/devices/system/cpu. Without
// one of both files for each core, all are 1.
void ReadCoreSpeeds(const char* folder, std::span<double> speeds) noexcept;

}  // namespace sweepstake
