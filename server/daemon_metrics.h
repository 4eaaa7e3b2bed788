// What the daemon tells Prometheus. Names and units follow Prometheus' conventions, and no label
// names a scene or a client, so that the number of series does not grow.
#pragma once

#include <prometheus/gauge.h>
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

  // What of the store was lost or damaged at the start: 1 if something, else 0.
  void SetDamaged(bool damaged) { damaged_.Set(damaged ? 1 : 0); }
  // The size that the store's file may have.
  void SetMaxStoreBytes(uint64_t bytes) { max_store_bytes_.Set(static_cast<double>(bytes)); }

  // Returns everything that /metrics shows. `database` is the store's file.
  std::vector<prometheus::MetricFamily> Collect(const rpc::Counters& counters, bool store_healthy,
                                                const std::filesystem::path& database) const;

 private:
  static void Observe(prometheus::Histogram& histogram, std::chrono::nanoseconds duration) {
    histogram.Observe(std::chrono::duration<double>(duration).count());
  }

  prometheus::Registry registry_;
  prometheus::Histogram& commits_;
  prometheus::Histogram& syncs_;
  prometheus::Histogram& timer_lateness_;
  prometheus::Gauge& damaged_;
  prometheus::Gauge& max_store_bytes_;
};

}  // namespace sweepstake::server
