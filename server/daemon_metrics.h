// What the daemon tells Prometheus. Names and units follow Prometheus' conventions, and no label
// names a scene or a client, so that the number of series does not grow.
#pragma once

#include <prometheus/histogram.h>
#include <prometheus/metric_family.h>
#include <prometheus/registry.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "server/rpc/common/options.h"

namespace sweepstake::server {

// Keeps how long things take, and adds what is counted elsewhere. Thread-safe.
class DaemonMetrics {
 public:
  explicit DaemonMetrics(const std::string& version);

  void OnCommit(std::chrono::nanoseconds duration) { Observe(commits_, duration); }
  void OnSync(std::chrono::nanoseconds duration) { Observe(syncs_, duration); }
  void OnTimer(std::chrono::nanoseconds lateness) { Observe(timer_lateness_, lateness); }

  // Returns everything that /metrics shows.
  std::vector<prometheus::MetricFamily> Collect(const rpc::Counters& counters, bool store_healthy,
                                                const std::filesystem::path& write_ahead_log) const;

 private:
  static void Observe(prometheus::Histogram& histogram, std::chrono::nanoseconds duration) {
    histogram.Observe(std::chrono::duration<double>(duration).count());
  }

  prometheus::Registry registry_;
  prometheus::Histogram& commits_;
  prometheus::Histogram& syncs_;
  prometheus::Histogram& timer_lateness_;
};

}  // namespace sweepstake::server
