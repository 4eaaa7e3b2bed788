// What the daemon tells Prometheus. Names and units follow Prometheus' conventions, and no label
// names a scene or a client, so that the number of series does not grow.
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

#include "server/rpc/common/options.h"
#include "server/web/api/topic.h"

namespace sweepstake::server {

// The store at the time of a scrape.
struct StoreState {
  bool healthy = true;
  size_t queued_commit_count = 0;
  size_t queued_read_count = 0;
  std::filesystem::path database;  // its file
};

// Keeps how long things take, and adds what is counted elsewhere. Thread-safe.
class DaemonMetrics {
 public:
  explicit DaemonMetrics(const std::string& version);

  void OnCommit(std::chrono::nanoseconds duration) { Observe(commits_, duration); }
  void OnRead(std::chrono::nanoseconds duration) { Observe(reads_, duration); }
  void OnSync(std::chrono::nanoseconds duration) { Observe(syncs_, duration); }
  void OnTimer(std::chrono::nanoseconds lateness) { Observe(timer_lateness_, lateness); }

  // What of the store was lost or damaged at the start: 1 if something, else 0.
  void SetDamaged(bool damaged) { damaged_.Set(damaged ? 1 : 0); }
  void OnFolded(uint64_t source_count) {
    folded_sources_.Increment(static_cast<double>(source_count));
  }
  // The size that the store's file may have, and how much of it is in use.
  void SetMaxStoreBytes(uint64_t bytes) { max_store_bytes_.Set(static_cast<double>(bytes)); }
  void SetUsedStoreBytes(uint64_t bytes) { used_store_bytes_.Set(static_cast<double>(bytes)); }

  // Whether the files of TLS could be used when they were read last, and when the certificate in
  // use expires. Without TLS there are no such metrics.
  void SetTls(bool could_be_used, int64_t expires_unix_s);

  // Returns everything that /metrics shows.
  std::vector<prometheus::MetricFamily> Collect(const rpc::Counters& counters,
                                                const web::EventCounters& events,
                                                const StoreState& store) const;

 private:
  static void Observe(prometheus::Histogram& histogram, std::chrono::nanoseconds duration) {
    histogram.Observe(std::chrono::duration<double>(duration).count());
  }

  prometheus::Registry registry_;
  prometheus::Histogram& commits_;
  prometheus::Histogram& reads_;
  prometheus::Histogram& syncs_;
  prometheus::Histogram& timer_lateness_;
  prometheus::Gauge& damaged_;
  prometheus::Gauge& max_store_bytes_;
  prometheus::Gauge& used_store_bytes_;
  prometheus::Counter& folded_sources_;
};

}  // namespace sweepstake::server
