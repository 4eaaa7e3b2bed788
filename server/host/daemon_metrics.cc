#include "server/host/daemon_metrics.h"

#include <atomic>
#include <cstdint>
#include <system_error>
#include <utility>

#include "server/host/process_metrics.h"
#include "server/rpc/common/error_reasons.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/web/metrics_page.h"

namespace sweepstake::server {
namespace {

using rpc::Counters;
using web::CounterOf;
using web::GaugeOf;

// In seconds. An fsync takes from some 20 us on a fast disk to seconds on one that is overloaded.
prometheus::Histogram::BucketBoundaries DurationBuckets() {
  return {0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025,
          0.05,   0.1,     0.25,   0.5,   1,      2.5,   5,    10};
}

prometheus::Histogram& AddHistogram(prometheus::Registry& registry, const char* name,
                                    const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry).Add(
      {}, DurationBuckets());
}

prometheus::Gauge& AddGauge(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildGauge().Name(name).Help(help).Register(registry).Add({});
}

struct CounterRow {
  std::atomic<uint64_t> Counters::*value;
  const char* name;
  const char* help;
};

constexpr CounterRow kGauges[] = {
    {&Counters::open_stream_count, "sweepstake_open_streams", "Streams of games that are open."},
    {&Counters::session_count, "sweepstake_sessions",
     "Sessions in memory, those that lost their connection among them."},
    {&Counters::open_watcher_count, "sweepstake_open_watchers", "Watchers that are connected."},
    {&Counters::waiting_audit_bytes, "sweepstake_waiting_audit_bytes",
     "Bytes of the audit log that wait for the disk."},
};

constexpr CounterRow kCounters[] = {
    {&Counters::flooding_connection_count, "sweepstake_flooding_connections_total",
     "Connections that were ended because they began too many calls."},
    {&Counters::connected_stream_count, "sweepstake_welcomed_streams_total",
     "Streams that got a welcome."},
    {&Counters::resumed_count, "sweepstake_resumed_sessions_total",
     "Welcomes that resumed a session."},
    {&Counters::degraded_start_count, "sweepstake_degraded_starts_total",
     "Sessions that began without evidence that the store could not read."},
    {&Counters::goodbye_count, "sweepstake_ended_sessions_total", "Sessions that a client ended."},
    {&Counters::malformed_message_count, "sweepstake_malformed_messages_total",
     "Messages that could not be parsed."},
    {&Counters::invalid_message_count, "sweepstake_invalid_messages_total",
     "Messages that broke a rule of the contract."},
    {&Counters::unknown_message_count, "sweepstake_unknown_messages_total",
     "Messages of a newer protocol, which were not applied."},
    {&Counters::replayed_message_count, "sweepstake_replayed_messages_total",
     "Messages that had been applied before."},
    {&Counters::applied_message_count, "sweepstake_applied_messages_total",
     "Messages that were applied."},
    {&Counters::accepted_frame_count, "sweepstake_accepted_frames_total",
     "Frames that were learnt from or waited to be."},
    {&Counters::accepted_shadow_count, "sweepstake_accepted_shadow_samples_total",
     "Shadow visits that were learnt from or waited to be."},
    {&Counters::surplus_bail_out_count, "sweepstake_surplus_bail_outs_total",
     "Bail-outs that were answered but are no evidence, because a game, or the games of a token or "
     "an address, cannot have so many."},
    {&Counters::dropped_frame_count, "sweepstake_dropped_frames_total",
     "Frames that the clients' queues dropped."},
    {&Counters::decision_count, "sweepstake_decisions_total", "Decisions that were taken."},
    {&Counters::switch_command_count, "sweepstake_switch_commands_total",
     "Switch commands that were given."},
    {&Counters::refused_switch_count, "sweepstake_refused_switches_total",
     "Switch commands that a client did not execute."},
    {&Counters::stored_commit_count, "sweepstake_stored_commits_total",
     "Commits of sessions that are on disk."},
    {&Counters::failed_commit_count, "sweepstake_failed_commits_total",
     "Commits of sessions that failed and are tried again."},
    {&Counters::lost_audit_row_count, "sweepstake_lost_audit_rows_total",
     "Rows that are missing in the audit log because the disk was too slow or failed."},
};

// The labels are the reasons of errors.proto, so that there are few of them.
prometheus::MetricFamily ErrorsOf(const Counters& counters) {
  prometheus::MetricFamily family;
  family.name = "sweepstake_errors_total";
  family.help = "Calls and streams that the daemon ended with an error, by its reason.";
  family.type = prometheus::MetricType::Counter;
  for (int number = 0; number < v1::ErrorReason_ARRAYSIZE; ++number) {
    if (!v1::ErrorReason_IsValid(number)) continue;
    prometheus::ClientMetric& metric = family.metric.emplace_back();
    const auto reason = static_cast<v1::ErrorReason>(number);
    metric.label.push_back({"reason", std::string(rpc::NameOf(reason))});
    metric.counter.value = static_cast<double>(counters.error_counts.at(reason));
  }
  return family;
}

// The labels are the values that cannot have been measured.
prometheus::MetricFamily RejectionsOf(const char* name, const char* help,
                                      const rpc::RejectionCounts& counts) {
  prometheus::MetricFamily family;
  family.name = name;
  family.help = help;
  family.type = prometheus::MetricType::Counter;
  for (size_t i = 0; i < counts.size(); ++i) {
    prometheus::ClientMetric& metric = family.metric.emplace_back();
    metric.label.push_back({"reason", std::string(rpc::kRejectionReasonNames.at(i))});
    metric.counter.value = static_cast<double>(counts.at(i));
  }
  return family;
}

std::vector<prometheus::MetricFamily> FamiliesOf(const web::EventCounters& events) {
  return {GaugeOf("sweepstake_http_watchers", "Who watches events by HTTP.",
                  static_cast<double>(events.open_watcher_count)),
          GaugeOf("sweepstake_http_topics", "Streams of events that they share.",
                  static_cast<double>(events.open_topic_count)),
          CounterOf("sweepstake_http_encoded_events_total",
                    "Messages that were made JSON for all watchers of their topic.",
                    static_cast<double>(events.encoded_count)),
          CounterOf("sweepstake_http_skips_total",
                    "Times that a watcher read so slowly that it was sent the state anew.",
                    static_cast<double>(events.skip_count))};
}

// Returns 0 if there is no such file: a store that is closed in order has no log.
double FileBytes(const std::filesystem::path& path) {
  std::error_code missing;
  const uintmax_t bytes = std::filesystem::file_size(path, missing);
  return missing ? 0 : static_cast<double>(bytes);
}

double LastBackupUnixS(const std::filesystem::path& database) {
  const auto time = storage::LastBackupTime(database);
  if (!time) return 0;
  const auto unix_time = std::chrono::file_clock::to_sys(*time).time_since_epoch();
  return std::chrono::duration<double>(unix_time).count();
}

}  // namespace

DaemonMetrics::DaemonMetrics(const std::string& version)
    : commits_(AddHistogram(registry_, "sweepstake_store_commit_duration_seconds",
                            "How long the store took to commit a group of updates.")),
      reads_(AddHistogram(registry_, "sweepstake_store_read_duration_seconds",
                          "How long reads of the store took, their time in the queue included.")),
      syncs_(AddHistogram(registry_, "sweepstake_store_fsync_duration_seconds",
                          "How long the fsyncs of the store's write-ahead log took.")),
      timer_lateness_(AddHistogram(registry_, "sweepstake_decision_loop_lateness_seconds",
                                   "How late the decision loop ran its timers, the ticks of the "
                                   "sessions among them.")),
      damaged_(AddGauge(registry_, "sweepstake_store_damaged",
                        "1 if the store lost evidence or has wrong rows since its start, else 0.")),
      max_store_bytes_(AddGauge(registry_, "sweepstake_store_max_size_bytes",
                                "Size that the store's file may have.")),
      used_store_bytes_(AddGauge(registry_, "sweepstake_store_used_size_bytes",
                                 "Bytes of the store's file that are in use; the others of it are "
                                 "used before it grows.")),
      folded_sources_(prometheus::BuildCounter()
                          .Name("sweepstake_store_folded_sources_total")
                          .Help("Sessions whose evidence was folded into that of their month.")
                          .Register(registry_)
                          .Add({})) {
  prometheus::BuildGauge()
      .Name("sweepstake_build_info")
      .Help("1, with the version of the daemon.")
      .Register(registry_)
      .Add({{"version", version}})
      .Set(1);
}

void DaemonMetrics::SetTls(bool could_be_used, int64_t expires_unix_s) {
  AddGauge(registry_, "sweepstake_tls_last_reload_successful",
           "1 if the files of TLS could be used when they were read last, else 0.")
      .Set(could_be_used ? 1 : 0);
  AddGauge(
      registry_, "sweepstake_tls_certificate_expiry_timestamp_seconds",
      "Unix time at which the daemon's certificate, or one of its issuers' beside it, expires.")
      .Set(static_cast<double>(expires_unix_s));
}

std::vector<prometheus::MetricFamily> DaemonMetrics::Collect(const rpc::Counters& counters,
                                                             const web::EventCounters& events,
                                                             const StoreState& store) const {
  std::vector<prometheus::MetricFamily> families = registry_.Collect();
  for (const auto& [value, name, help] : kGauges)
    families.push_back(GaugeOf(name, help, static_cast<double>(counters.*value)));
  for (const auto& [value, name, help] : kCounters)
    families.push_back(CounterOf(name, help, static_cast<double>(counters.*value)));
  families.push_back(RejectionsOf("sweepstake_rejected_frames_total",
                                  "Frames with a value that cannot be, by which it is.",
                                  counters.rejected_frame_counts));
  families.push_back(RejectionsOf("sweepstake_rejected_shadow_samples_total",
                                  "Shadow visits with a value that cannot be, by which it is.",
                                  counters.rejected_shadow_counts));
  families.push_back(ErrorsOf(counters));
  for (auto& family : FamiliesOf(events)) families.push_back(std::move(family));
  families.push_back(GaugeOf("sweepstake_store_healthy",
                             "1 while the store can write and read, 0 after a commit failed, while "
                             "its file is not in its place or while a read does not end.",
                             store.healthy ? 1 : 0));
  families.push_back(GaugeOf("sweepstake_store_queued_commits",
                             "Updates of sessions, imports among them, that wait to be written.",
                             static_cast<double>(store.queued_commit_count)));
  families.push_back(GaugeOf("sweepstake_store_queued_reads",
                             "Reads of the store that wait for those before them.",
                             static_cast<double>(store.queued_read_count)));
  families.push_back(GaugeOf("sweepstake_store_wal_size_bytes",
                             "Size of the store's write-ahead log.",
                             FileBytes(store.database.string() + "-wal")));
  families.push_back(GaugeOf("sweepstake_store_size_bytes", "Size of the store's file.",
                             FileBytes(store.database)));
  families.push_back(GaugeOf("sweepstake_store_last_backup_timestamp_seconds",
                             "Unix time of the last backup beside the store, or 0.",
                             LastBackupUnixS(store.database)));
  for (auto& family : ProcessFamilies()) families.push_back(std::move(family));
  return families;
}

}  // namespace sweepstake::server
