#include "engine_client/broad_phase/host/usable_cores.h"

#include <algorithm>
#include <thread>

#if defined(_WIN32)
#ifndef NOMINMAX
#define NOMINMAX
#endif
#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>

#include <bit>
#include <cstdint>
#elif defined(__linux__)
#include <sched.h>

#include <cstdio>
#include <cstring>
#endif

namespace sweepstake {
namespace {

#if defined(_WIN32)

size_t CoresOfAffinity() noexcept {
  DWORD_PTR own = 0;
  DWORD_PTR of_system = 0;
  if (GetProcessAffinityMask(GetCurrentProcess(), &own, &of_system) == 0) return 0;
  return static_cast<size_t>(std::popcount(uint64_t{own}));
}
size_t CoresOfQuota() noexcept { return 0; }

#elif defined(__linux__)

size_t CoresOfAffinity() noexcept {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return 0;
  return static_cast<size_t>(CPU_COUNT(&set));
}

// Returns the quota in the file `cpu.max` of one control group, in cores, or 0 if there is no
// limit.
double QuotaOf(const char* path) noexcept {
  std::FILE* const file = std::fopen(path, "re");
  if (file == nullptr) return 0;
  double quota_us = 0;
  double period_us = 0;
  const int count = std::fscanf(file, "%lf %lf", &quota_us, &period_us);  // "max" does not parse
  std::fclose(file);
  return count == 2 && quota_us > 0 && period_us > 0 ? quota_us / period_us : 0;
}

// Returns the smallest quota of the process's control group and of all groups above it, in whole
// cores. Returns 0 if there is no quota.
size_t CoresOfQuota() noexcept {
  static constexpr char kRoot[] = "/sys/fs/cgroup";
  char path[4096] = "/proc/self/cgroup";
  std::FILE* const file = std::fopen(path, "re");
  if (file == nullptr) return 0;
  char line[2048];
  size_t length = 0;
  while (std::fgets(line, sizeof line, file) != nullptr) {
    if (std::strncmp(line, "0::/", 4) != 0) continue;
    line[std::strcspn(line, "\n")] = 0;
    length = static_cast<size_t>(std::snprintf(path, sizeof path, "%s%s", kRoot, line + 3));
    break;
  }
  std::fclose(file);
  double least = 0;
  while (length >= sizeof kRoot - 1) {
    std::snprintf(path + length, sizeof path - length, "/cpu.max");
    const double quota = QuotaOf(path);
    if (quota > 0 && (least == 0 || quota < least)) least = quota;
    path[length] = 0;
    const char* const slash = std::strrchr(path, '/');
    length = static_cast<size_t>(slash - path);
  }
  return least == 0 ? 0 : std::max<size_t>(static_cast<size_t>(least), 1);
}

#else

size_t CoresOfAffinity() noexcept { return 0; }
size_t CoresOfQuota() noexcept { return 0; }

#endif

}  // namespace

// If the affinity is unknown (0), starts from the number of hardware threads. A quota of 0 means
// that there is none.
size_t UsableCores() noexcept {
  size_t cores = CoresOfAffinity();
  if (cores == 0) cores = std::max(std::thread::hardware_concurrency(), 1U);
  const size_t of_quota = CoresOfQuota();
  return of_quota == 0 ? cores : std::min(cores, of_quota);
}

}  // namespace sweepstake
