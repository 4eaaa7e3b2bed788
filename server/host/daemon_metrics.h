// The metrics of the daemon for Prometheus. Names and units follow its conventions. No label
// contains a client, and a setting bounds the number of scenes in labels (scene_metrics.h).
#pragma once

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/metric_family.h>
#include <prometheus/registry.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "server/alerts/alert_monitor.h"
#include "server/alerts/webhook.h"
#include "server/rpc/common/options.h"
#include "server/web/api/topic.h"

namespace sweepstake::server {

// State of the store when Prometheus reads /metrics.
struct StoreState {
  bool healthy = true;
  size_t queued_commit_count = 0;
  size_t queued_read_count = 0;
  std::filesystem::path database;  // file of the store
};

// Returns the metrics that every Prometheus client exports about its process: start time, CPU,
// memory, descriptors. Reads /proc. A metric that cannot be read is omitted.
std::vector<prometheus::MetricFamily> ProcessFamilies();

// Measures durations, and collects the counters of other objects. Thread-safe.
class DaemonMetrics {
 public:
  explicit DaemonMetrics(const std::string& version);

  void OnCommit(std::chrono::nanoseconds duration) { Observe(commits_, duration); }
  void OnRead(std::chrono::nanoseconds duration) { Observe(reads_, duration); }
  void OnSync(std::chrono::nanoseconds duration) { Observe(syncs_, duration); }
  void OnHttpDropped() { dropped_http_connections_.Increment(); }
  void OnTimer(std::chrono::nanoseconds lateness) { Observe(timer_lateness_, lateness); }

  // Reports whether the store lost evidence or has damaged rows since its start.
  void SetDamaged(bool damaged) { damaged_.Set(damaged ? 1 : 0); }
  // Report the maximum size of the store's file, and how much of it is in use.
  void SetMaxStoreBytes(uint64_t bytes) { max_store_bytes_.Set(static_cast<double>(bytes)); }
  void SetUsedStoreBytes(uint64_t bytes) { used_store_bytes_.Set(static_cast<double>(bytes)); }

  // Reports whether the TLS files were valid when they were read last, and when the certificate in
  // use expires. Before the first call, /metrics does not contain these two metrics.
  void SetTls(bool valid, int64_t expires_unix_s);

  // Returns everything that /metrics shows.
  std::vector<prometheus::MetricFamily> Collect(const rpc::Counters& counters,
                                                const web::EventCounters& events,
                                                const StoreState& store,
                                                const alerts::AlertFigures& alerts,
                                                const alerts::WebhookCounters& webhook) const;

 private:
  static void Observe(prometheus::Histogram& histogram, std::chrono::nanoseconds duration) {
    histogram.Observe(std::chrono::duration<double>(duration).count());
  }

  prometheus::Registry registry_;
  prometheus::Histogram& commits_;
  prometheus::Histogram& reads_;
  prometheus::Histogram& syncs_;
  prometheus::Histogram& timer_lateness_;
  prometheus::Counter& dropped_http_connections_;
  prometheus::Gauge& damaged_;
  prometheus::Gauge& max_store_bytes_;
  prometheus::Gauge& used_store_bytes_;
};

}  // namespace sweepstake::server
