#include "engine_client/broad_phase/host/core_speed.h"

#include <algorithm>
#include <cstdio>

#if defined(__linux__)
#include <sched.h>
#include <unistd.h>

#include <array>
#endif

namespace sweepstake {
namespace {

// The number in folder/cpuCORE/name; 0: there is none.
double RatingOf(const char* folder, size_t core, const char* name) noexcept {
  char path[4096];
  std::snprintf(path, sizeof path, "%s/cpu%zu/%s", folder, core, name);
  std::FILE* const file = std::fopen(path, "r");
  if (file == nullptr) return 0;
  double rating = 0;
  const int count = std::fscanf(file, "%lf", &rating);
  std::fclose(file);
  return count == 1 && rating > 0 ? rating : 0;
}

bool ReadRatings(const char* folder, const char* name, std::span<double> ratings) noexcept {
  for (size_t core = 0; core < ratings.size(); ++core) {
    ratings[core] = RatingOf(folder, core, name);
    if (ratings[core] == 0) return false;
  }
  return true;
}

}  // namespace

void ReadCoreSpeeds(const char* folder, std::span<double> speeds) noexcept {
  if (speeds.empty()) return;
  if (!ReadRatings(folder, "cpu_capacity", speeds) &&
      !ReadRatings(folder, "acpi_cppc/highest_perf", speeds)) {
    std::fill(speeds.begin(), speeds.end(), 1.0);
    return;
  }
  const double fastest = *std::max_element(speeds.begin(), speeds.end());
  for (double& speed : speeds) speed = speed < kOneKind * fastest ? speed / fastest : 1.0;
}

#if defined(__linux__)

double CoreSpeed() noexcept {
  struct Table {
    std::array<double, CPU_SETSIZE> speeds{};
    size_t count = 0;
  };
  static const Table table = [] {
    Table read;
    read.count = std::clamp<size_t>(static_cast<size_t>(sysconf(_SC_NPROCESSORS_CONF)), 1,
                                    read.speeds.size());
    ReadCoreSpeeds("/sys/devices/system/cpu", std::span(read.speeds).first(read.count));
    return read;
  }();
  const auto core = static_cast<size_t>(sched_getcpu());
  return core < table.count ? table.speeds[core] : 1.0;
}

#else

double CoreSpeed() noexcept { return 1.0; }

#endif

}  // namespace sweepstake
