#include "server/host/daemon_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "server/host/scene_metrics.h"
#include "server/rpc/common/error_reasons.h"
#include "server/storage/backup/automatic_backup.h"
#include "server/web/metrics_page.h"

namespace sweepstake::server {
namespace {

using rpc::Counters;
using web::CounterOf;
using web::GaugeOf;

// Upper bounds of the buckets in seconds. An fsync takes from 20 us on a fast disk to seconds on an
// overloaded one.
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
    {&Counters::open_stream_count, "sweepstake_open_streams", "Open game streams."},
    {&Counters::session_count, "sweepstake_sessions",
     "Sessions in memory, including those that lost their connection."},
    {&Counters::open_watcher_count, "sweepstake_open_watchers", "Connected watchers."},
    {&Counters::waiting_audit_bytes, "sweepstake_waiting_audit_bytes",
     "Bytes of the audit log that wait for the disk."},
};

constexpr CounterRow kCounters[] = {
    {&Counters::refused_connection_count, "sweepstake_refused_connections_total",
     "Connections that were closed because they reset too many calls, or were not HTTP/2."},
    {&Counters::unread_call_count, "sweepstake_unread_calls_total",
     "Calls that were ended before their message was read: it was too long, compressed or late."},
    {&Counters::connected_stream_count, "sweepstake_welcomed_streams_total",
     "Streams that received a welcome."},
    {&Counters::resumed_count, "sweepstake_resumed_sessions_total",
     "Welcomes that resumed a session."},
    {&Counters::degraded_start_count, "sweepstake_degraded_starts_total",
     "Sessions that started without their evidence, because the store could not read it."},
    {&Counters::unknown_arm_session_count, "sweepstake_sessions_with_unknown_arms_total",
     "Sessions of players with arms that are not known, about which no evidence is stored."},
    {&Counters::limited_player_evidence_count, "sweepstake_limited_player_records_total",
     "Records of players that were not stored, or without their regime, because players had added "
     "the maximum of machine classes or regimes."},
    {&Counters::goodbye_count, "sweepstake_ended_sessions_total", "Sessions that a client ended."},
    {&Counters::malformed_message_count, "sweepstake_malformed_messages_total",
     "Messages that could not be parsed."},
    {&Counters::invalid_message_count, "sweepstake_invalid_messages_total",
     "Messages that violated a rule of the protocol."},
    {&Counters::unknown_message_count, "sweepstake_unknown_messages_total",
     "Messages of a newer protocol, which were ignored."},
    {&Counters::replayed_message_count, "sweepstake_replayed_messages_total",
     "Messages that had already been applied."},
    {&Counters::applied_message_count, "sweepstake_applied_messages_total",
     "Messages that were applied."},
    {&Counters::accepted_frame_count, "sweepstake_accepted_frames_total",
     "Frames that were accepted for learning."},
    {&Counters::suspended_frame_count, "sweepstake_suspended_frames_total",
     "Accepted frames that do not count as evidence, because the system stopped the game."},
    {&Counters::invalid_box_batch_count, "sweepstake_invalid_box_batches_total",
     "Batches of frames in which some objects had invalid boxes and therefore collided with "
     "nothing."},
    {&Counters::accepted_shadow_count, "sweepstake_accepted_shadow_samples_total",
     "Shadow visits that were accepted for learning."},
    {&Counters::surplus_bail_out_count, "sweepstake_surplus_bail_outs_total",
     "Bail-outs that were handled but do not count as evidence, because their game, token or "
     "address exceeded its rate."},
    {&Counters::dropped_frame_count, "sweepstake_dropped_frames_total",
     "Frames that the queues of clients dropped."},
    {&Counters::decision_count, "sweepstake_decisions_total", "Decisions."},
    {&Counters::switch_command_count, "sweepstake_switch_commands_total",
     "Switch commands that were sent."},
    {&Counters::refused_switch_count, "sweepstake_refused_switches_total",
     "Switch commands that a client did not execute."},
    {&Counters::stored_commit_count, "sweepstake_stored_commits_total",
     "Session commits that are on disk."},
    {&Counters::failed_commit_count, "sweepstake_failed_commits_total",
     "Session commits that failed and are retried."},
    {&Counters::lost_audit_row_count, "sweepstake_lost_audit_rows_total",
     "Audit rows that were lost because the disk was too slow or failed."},
};

// Returns the counts of errors by reason (errors.proto), so the number of labels is bounded.
prometheus::MetricFamily ErrorsOf(const Counters& counters) {
  prometheus::MetricFamily family;
  family.name = "sweepstake_errors_total";
  family.help = "Calls and streams that ended with an error, by reason.";
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

// Returns the counts of rejections, labelled by the invalid fields.
prometheus::MetricFamily RejectionsOf(const char* name, const char* help,
                                      const sessions::RejectionCounts& counts) {
  prometheus::MetricFamily family;
  family.name = name;
  family.help = help;
  family.type = prometheus::MetricType::Counter;
  for (size_t i = 0; i < counts.size(); ++i) {
    prometheus::ClientMetric& metric = family.metric.emplace_back();
    metric.label.push_back({"reason", std::string(sessions::kRejectionReasonNames.at(i))});
    metric.counter.value = static_cast<double>(counts.at(i));
  }
  return family;
}

std::vector<prometheus::MetricFamily> FamiliesOf(const web::EventCounters& events) {
  return {GaugeOf("sweepstake_http_watchers", "Watchers of events over HTTP.",
                  static_cast<double>(events.open_watcher_count)),
          GaugeOf("sweepstake_http_topics", "Event streams that HTTP watchers share.",
                  static_cast<double>(events.open_topic_count)),
          CounterOf("sweepstake_http_encoded_events_total",
                    "Messages that were encoded as JSON, once for all watchers.",
                    static_cast<double>(events.encoded_count)),
          CounterOf("sweepstake_http_skips_total",
                    "Times that a watcher read too slowly and was sent the whole state again.",
                    static_cast<double>(events.skip_count))};
}

std::vector<prometheus::MetricFamily> FamiliesOf(const alerts::WebhookCounters& webhook) {
  return {CounterOf("sweepstake_webhook_messages_total",
                    "Messages about alerts that the webhook's receiver has accepted.",
                    static_cast<double>(webhook.delivered_count)),
          CounterOf("sweepstake_webhook_failed_attempts_total",
                    "Attempts to send a message to the webhook that failed.",
                    static_cast<double>(webhook.failed_count)),
          CounterOf("sweepstake_webhook_dropped_messages_total",
                    "Messages that were not sent: too many waited, or all attempts failed.",
                    static_cast<double>(webhook.dropped_count)),
          GaugeOf("sweepstake_webhook_queued_messages", "Messages that wait to be sent.",
                  static_cast<double>(webhook.queued_count))};
}

// Returns 0 if the file does not exist: a store that was closed in order has no write-ahead log.
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

// The needed fields of /proc/self/stat, in the order of proc(5).
struct ProcessStat {
  double user_ticks = 0;
  double system_ticks = 0;
  double start_ticks = 0;  // from the machine's start to the process's start
  double resident_pages = 0;
};

// Returns nothing if the file cannot be read, for instance because no descriptor is free.
std::optional<ProcessStat> ReadStat() {
  std::ifstream file("/proc/self/stat");
  const std::string line{std::istreambuf_iterator<char>(file), {}};
  // The second field, the program's name, may contain blanks and parentheses. The third field
  // follows the last parenthesis.
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

DaemonMetrics::DaemonMetrics(const std::string& version)
    : commits_(AddHistogram(registry_, "sweepstake_store_commit_duration_seconds",
                            "Time that the store took to commit a group of updates.")),
      reads_(AddHistogram(registry_, "sweepstake_store_read_duration_seconds",
                          "Time of store reads, including their time in the queue.")),
      syncs_(AddHistogram(registry_, "sweepstake_store_fsync_duration_seconds",
                          "Time of fsyncs of the store's write-ahead log.")),
      timer_lateness_(AddHistogram(registry_, "sweepstake_decision_loop_lateness_seconds",
                                   "How late the decision loop ran its timers, including the "
                                   "ticks of sessions.")),
      dropped_http_connections_(
          prometheus::BuildCounter()
              .Name("sweepstake_dropped_http_connections_total")
              .Help("Idle HTTP connections that were closed to make room for new ones.")
              .Register(registry_)
              .Add({})),
      damaged_(
          AddGauge(registry_, "sweepstake_store_damaged",
                   "1 if the store lost evidence or has damaged rows since its start, else 0.")),
      max_store_bytes_(AddGauge(registry_, "sweepstake_store_max_size_bytes",
                                "Maximum size of the store's file.")),
      used_store_bytes_(AddGauge(registry_, "sweepstake_store_used_size_bytes",
                                 "Bytes of the store's file that are in use; the file grows only "
                                 "when all its bytes are in use.")) {
  prometheus::BuildGauge()
      .Name("sweepstake_build_info")
      .Help("Always 1; the label is the version of the daemon.")
      .Register(registry_)
      .Add({{"version", version}})
      .Set(1);
}

void DaemonMetrics::SetTls(bool valid, int64_t expires_unix_s) {
  AddGauge(registry_, "sweepstake_tls_last_reload_successful",
           "1 if the TLS files were valid when they were read last, else 0.")
      .Set(valid ? 1 : 0);
  AddGauge(registry_, "sweepstake_tls_certificate_expiry_timestamp_seconds",
           "Unix time at which the daemon's certificate, or an issuer's in the same file, expires.")
      .Set(static_cast<double>(expires_unix_s));
}

std::vector<prometheus::MetricFamily> DaemonMetrics::Collect(
    const rpc::Counters& counters, const web::EventCounters& events, const StoreState& store,
    const alerts::AlertFigures& alerts, const alerts::WebhookCounters& webhook) const {
  std::vector<prometheus::MetricFamily> families = registry_.Collect();
  for (const auto& [value, name, help] : kGauges)
    families.push_back(GaugeOf(name, help, static_cast<double>(counters.*value)));
  for (const auto& [value, name, help] : kCounters)
    families.push_back(CounterOf(name, help, static_cast<double>(counters.*value)));
  families.push_back(RejectionsOf("sweepstake_rejected_frames_total",
                                  "Frames rejected because a field is invalid, by field.",
                                  counters.rejected_frame_counts));
  families.push_back(RejectionsOf("sweepstake_rejected_shadow_samples_total",
                                  "Shadow visits rejected because a field is invalid, by field.",
                                  counters.rejected_shadow_counts));
  families.push_back(ErrorsOf(counters));
  for (auto& family : FamiliesOf(events)) families.push_back(std::move(family));
  for (auto& family : AlertFamilies(alerts)) families.push_back(std::move(family));
  for (auto& family : FamiliesOf(webhook)) families.push_back(std::move(family));
  families.push_back(GaugeOf("sweepstake_store_healthy",
                             "1 while the store can write and read; 0 after a failed commit, while "
                             "its file is missing, or while a read does not end.",
                             store.healthy ? 1 : 0));
  families.push_back(GaugeOf("sweepstake_store_queued_commits",
                             "Updates of sessions and imports that wait for a commit.",
                             static_cast<double>(store.queued_commit_count)));
  families.push_back(GaugeOf("sweepstake_store_queued_reads", "Store reads that wait in the queue.",
                             static_cast<double>(store.queued_read_count)));
  families.push_back(GaugeOf("sweepstake_store_wal_size_bytes",
                             "Size of the store's write-ahead log.",
                             FileBytes(store.database.string() + "-wal")));
  families.push_back(GaugeOf("sweepstake_store_size_bytes", "Size of the store's file.",
                             FileBytes(store.database)));
  families.push_back(GaugeOf("sweepstake_store_last_backup_timestamp_seconds",
                             "Unix time of the last backup next to the store, or 0.",
                             LastBackupUnixS(store.database)));
  for (auto& family : ProcessFamilies()) families.push_back(std::move(family));
  return families;
}

}  // namespace sweepstake::server
