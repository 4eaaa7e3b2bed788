#include "engine_client/broad_phase/host/core_speed.h"

#if defined(__linux__)
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#endif

namespace sweepstake {

#if defined(__linux__)

namespace {

// Returns the number in the file FOLDER/cpuCORE/NAME, or 0 if there is none.
double RatingOf(const char* folder, size_t core, const char* name) noexcept {
  char path[4096];
  std::snprintf(path, sizeof path, "%s/cpu%zu/%s", folder, core, name);
  std::FILE* const file = std::fopen(path, "re");
  if (file == nullptr) return 0;
  double rating = 0;
  const int count = std::fscanf(file, "%lf", &rating);
  std::fclose(file);
  return count == 1 && rating > 0 ? rating : 0;
}

// Reads the rating of each core. Returns the highest rating, or 0 if there is none.
double ReadRatings(const char* folder, const char* name, std::span<double> ratings) noexcept {
  double highest = 0;
  for (size_t core = 0; core < ratings.size(); ++core) {
    ratings[core] = RatingOf(folder, core, name);
    highest = std::max(highest, ratings[core]);
  }
  return highest;
}

struct SpeedTable {
  SpeedTable() noexcept {
    const auto configured = static_cast<size_t>(sysconf(_SC_NPROCESSORS_CONF));
    count = std::clamp<size_t>(configured, 1, speeds.size());
    ReadCoreSpeeds("/sys/devices/system/cpu", std::span(speeds).first(count));
  }

  std::array<double, CPU_SETSIZE> speeds{};
  size_t count = 0;
};

}  // namespace

void ReadCoreSpeeds(const char* folder, std::span<double> speeds) noexcept {
  double highest = ReadRatings(folder, "cpu_capacity", speeds);
  double one_kind = highest;
  if (highest == 0) {
    highest = ReadRatings(folder, "acpi_cppc/highest_perf", speeds);
    one_kind = kOneKind * highest;
  }
  for (double& speed : speeds) speed = speed > 0 && speed < one_kind ? speed / highest : 1.0;
}

double CoreSpeed() noexcept {
  static const SpeedTable table;
  const auto core = static_cast<size_t>(sched_getcpu());
  return core < table.count ? table.speeds[core] : 1.0;
}

#else

double CoreSpeed() noexcept { return 1.0; }

#endif

}  // namespace sweepstake
