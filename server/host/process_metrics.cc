#include "server/host/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>

#include "server/web/metrics_page.h"

namespace sweepstake::server {
namespace {

using web::CounterOf;
using web::GaugeOf;

// The needed fields of /proc/self/stat, in the order of proc(5).
struct ProcessStat {
  double user_ticks = 0;
  double system_ticks = 0;
  double start_ticks = 0;  // since the machine's start
  double resident_pages = 0;
};

// Returns nothing if the file cannot be read, for instance because no descriptor is free.
std::optional<ProcessStat> ReadStat() {
  std::ifstream file("/proc/self/stat");
  const std::string line{std::istreambuf_iterator<char>(file), {}};
  // The second field, the name, may contain blanks and parentheses; the third follows the last one.
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  ProcessStat stat;
  std::string skipped;
  for (int field = 3; field <= 24 && fields; ++field) {
    double* wanted = field == 14   ? &stat.user_ticks
                     : field == 15 ? &stat.system_ticks
                     : field == 22 ? &stat.start_ticks
                     : field == 24 ? &stat.resident_pages
                                   : nullptr;
    wanted != nullptr ? fields >> *wanted : fields >> skipped;
  }
  return fields ? std::optional(stat) : std::nullopt;
}

// Returns when the machine started, in seconds since 1970.
std::optional<double> BootTime() {
  std::ifstream file("/proc/stat");
  for (std::string name; file >> name;) {
    double seconds = 0;
    if (name == "btime" && file >> seconds) return seconds;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return std::nullopt;
}

// Returns nothing if the folder cannot be read, for instance because no descriptor is free.
std::optional<double> OpenDescriptorCount() {
  std::error_code error;
  double count = -1;  // because listing the folder opens one descriptor
  for (std::filesystem::directory_iterator next("/proc/self/fd", error), end; !error && next != end;
       next.increment(error)) {
    ++count;
  }
  return error ? std::nullopt : std::optional(count);
}

double MaxDescriptorCount() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  return static_cast<double>(limit.rlim_cur);
}

}  // namespace

std::vector<prometheus::MetricFamily> ProcessFamilies() {
  const auto ticks_per_s = static_cast<double>(sysconf(_SC_CLK_TCK));
  const auto page_bytes = static_cast<double>(sysconf(_SC_PAGESIZE));
  std::vector<prometheus::MetricFamily> families = {
      GaugeOf("process_max_fds", "Maximum number of open file descriptors.", MaxDescriptorCount())};
  if (const std::optional<double> count = OpenDescriptorCount()) {
    families.push_back(GaugeOf("process_open_fds", "Number of open file descriptors.", *count));
  }
  const std::optional<ProcessStat> stat = ReadStat();
  if (!stat) return families;
  families.push_back(CounterOf("process_cpu_seconds_total",
                               "Total user and system CPU time spent in seconds.",
                               (stat->user_ticks + stat->system_ticks) / ticks_per_s));
  families.push_back(GaugeOf("process_resident_memory_bytes", "Resident memory size in bytes.",
                             stat->resident_pages * page_bytes));
  if (const std::optional<double> boot_time_s = BootTime()) {
    families.push_back(GaugeOf("process_start_time_seconds",
                               "Start time of the process since the Unix epoch.",
                               *boot_time_s + stat->start_ticks / ticks_per_s));
  }
  return families;
}

}  // namespace sweepstake::server
