// The bounds, intervals and counters of the services. Each field says what happens at its bound.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/options.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/auth/principal.h"
#include "server/sessions/adjustable.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

// The versions of the protocol that the daemon speaks.
inline constexpr uint32_t kMinProtocolVersion = 1;
inline constexpr uint32_t kMaxProtocolVersion = 2;
// A message beyond one of these three limits is INVALID_ARGUMENT.
inline constexpr uint32_t kMaxBatchFrames = 240;
inline constexpr uint32_t kMaxBatchShadows = 64;
inline constexpr size_t kMaxBoxViewBytes = 64 * 1024;
inline constexpr double kMaxTimeScale = 1000;
inline constexpr uint32_t kMaxMessageBytes = 256 * 1024;  // a longer message is RESOURCE_EXHAUSTED
inline constexpr uint64_t kMaxFrameNs = 3'600'000'000'000;  // an hour; a longer frame is left out
// An export sends this many records per message; an import with more in one is INVALID_ARGUMENT.
inline constexpr uint32_t kRecordsPerMessage = 200;
// One import has at most this many records, all imports under way have twice as many. More are
// RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxImportRecords = 200'000;
// So many records may wait to be promoted; an import that would make more of them is
// RESOURCE_EXHAUSTED.
inline constexpr uint64_t kMaxQuarantinedRecords = 1'000'000;
// A message of a listing has at most this many segments, a page of an export this many rows.
inline constexpr uint32_t kAuditSegmentsPerMessage = 100;
inline constexpr uint32_t kAuditRowsPerPage = 500;
// An export's message is sent once its rows have this many bytes; it may exceed that by one row.
inline constexpr size_t kAuditBytesPerMessage = 128 * 1024;
// The maximum bytes of audit rows that wait for the disk, of one session (64 rows of 7 arms, which
// are two minutes) and of all. A row beyond them is lost.
inline constexpr size_t kMaxWaitingAuditBytesOfSession = 64 * 1024;
inline constexpr size_t kMaxWaitingAuditBytes = 64 * 1024 * 1024;
// The bail-outs of a token, and of an address that is not the daemon's own machine, are evidence as
// often as those of so many games that have nothing else, one in each DecisionOptions::bail_out_ns,
// and at least so often in a second; as many as in ten seconds at once, which is more than one
// session may have (decision::BailOutBudget). However many sessions there are, those beyond it are
// answered, and are no evidence.
inline constexpr double kBailingOutGames = 10;
inline constexpr double kMinBailOutsPerS = 2;
// Streams that have no session, beside those of max_sessions. The next stream is
// RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxStreamsWithoutSession = 1'000;
inline constexpr uint32_t kScenesPerPage = 100;    // a listing gives no more scenes
inline constexpr uint32_t kSessionsPerPage = 100;  // a listing gives no more sessions
// A watcher gets no more decisions in one message, which then has 130 kB at most.
inline constexpr int kDecisionsPerMessage = 100;
// Decisions that wait for a watcher beyond this are dropped; of posteriors the latest always waits.
inline constexpr size_t kWatcherQueueBytes = 256 * 1024;

// The members that are Adjustable take effect at once when RpcServer::Adjust changes them.
struct RpcOptions {
  // The policy in it is that of sessions that name none.
  decision::DecisionOptions decision;
  std::string daemon_version;  // of the program, as in Welcome and the audit log
  // Whether the sessions that begin make rows of the audit log.
  Adjustable<bool> keeps_audit = true;
  // Whether other daemons write the store, too. Then a session that cannot be read now may have
  // gone on elsewhere, and is not begun anew: what its client sends again might count twice.
  bool shares_store = false;
  // Called on the decision loop with all that waits for the store, as it is to be committed: every
  // few seconds while that cannot be written, once after it could again, and at the end of Drain.
  // May be empty.
  std::function<void(std::vector<priors::SourceUpdate>)> keep_waiting = {};

  // The largest time scale that a Hello may ask for, 1 to kMaxTimeScale; a larger one is
  // INVALID_ARGUMENT. A session decides, commits and learns that many times as often.
  Adjustable<double> max_time_scale = 1;
  // The maximum number of sessions in memory, connected or resumable. At the bound the session that
  // was lost first leaves memory, but can still be resumed from the store. If all are connected, a
  // new one is RESOURCE_EXHAUSTED.
  Adjustable<uint32_t> max_sessions = 20'000;
  // The same of the sessions of one token, and of the streams from one address that is not the
  // daemon's own machine; beyond them a new one is RESOURCE_EXHAUSTED. A token alone thus leaves
  // half of the daemon to the others. Of connections such an address may have open_connections.h's
  // kSpare more; one beyond is closed.
  Adjustable<uint32_t> max_sessions_per_token = 10'000;
  Adjustable<uint32_t> max_streams_per_address = 2'000;
  // The maximum number of projects; one more, in a Hello or an import, is RESOURCE_EXHAUSTED. For a
  // Hello those count, too, that only sessions in memory have.
  Adjustable<uint32_t> max_projects = 100;
  // The maximum number of scenes of a project, by name, likewise.
  Adjustable<uint32_t> max_scenes = 1'000;
  // The maximum messages in a second of a stream, times its time scale, and as many as in ten
  // seconds at once; beyond it the stream ends with RESOURCE_EXHAUSTED. Welcome's batch interval
  // asks for four, a game of 10,000 frames/s needs 42, and one that has come back sends again what
  // was not acknowledged.
  Adjustable<uint32_t> max_messages_per_s = 200;
  // The maximum Hellos in a second of a token, and of an address that is not the daemon's own
  // machine, and as many as in ten seconds at once; one more is RESOURCE_EXHAUSTED. Each may cost a
  // read of the store. 10,000 games behind one address, which come back after a restart, fit into
  // what it may have at once.
  Adjustable<uint32_t> max_hellos_per_s = 1'000;
  // The maximum calls in a second of a token, and of an address, that list, export or begin to
  // watch, and as many as in ten seconds at once; one more is RESOURCE_EXHAUSTED.
  Adjustable<uint32_t> max_reads_per_s = 100;
  // The maximum number of exports and imports under way, of the daemon and of one token; one more
  // is RESOURCE_EXHAUSTED.
  Adjustable<uint32_t> max_transfers = 64;
  Adjustable<uint32_t> max_transfers_per_token = 16;
  // The tokens that calls must bring; without, or while there are none, everybody may do
  // everything. They outlive the server.
  const auth::TokenDirectory* tokens = nullptr;
  // The secret from which the resume token of every session is made, 32 random bytes. If it
  // changes, no earlier session can be resumed.
  std::string resume_secret;
  // Where the ids and seeds of new sessions come from. Called on the decision loop.
  std::function<uint64_t()> random_bits = [] {
    std::random_device device;
    return (uint64_t{device()} << 32) | device();
  };
  // A lost session leaves memory after this time; from then on it is resumed from the store.
  Adjustable<int64_t> resume_window_ns = 600'000'000'000;
  // The maximum number of watchers at a time; the next one is RESOURCE_EXHAUSTED. A token, and an
  // address that is not the daemon's own machine, may have half of them, rounded up.
  Adjustable<uint32_t> max_watchers = 256;
  // A watcher that does not read for this long is dropped with RESOURCE_EXHAUSTED; an export or
  // import that makes no progress for so long ends with DEADLINE_EXCEEDED.
  int64_t watcher_patience_ns = 20'000'000'000;
  // An export or import that is not done after this time, however it makes progress, ends with
  // DEADLINE_EXCEEDED. An audit log of 256 MiB takes ten minutes at 4 Mbit/s.
  int64_t transfer_patience_ns = 1'800'000'000'000;
  // A connection that has not become one of HTTP/2 after this time, with TLS where there is a
  // certificate, is closed.
  std::chrono::milliseconds handshake_patience{10'000};
  // A connection is asked to end after this time, varied by ±10 %, so that a client whose
  // certificate or authority is no longer valid does not stay; its calls have the grace to end.
  std::chrono::milliseconds connection_age = std::chrono::minutes(30);
  std::chrono::milliseconds connection_age_grace = std::chrono::minutes(1);
  // A connection that has had no call for so long is asked to end, since whoever makes one needs no
  // token; clients that wait between two calls connect again by themselves.
  std::chrono::milliseconds connection_idle_patience = std::chrono::minutes(1);
  // A connection on which nothing comes is asked for a sign of life in this interval, and closed
  // without one after the patience.
  std::chrono::milliseconds keepalive_interval = std::chrono::minutes(1);
  std::chrono::milliseconds keepalive_patience = std::chrono::seconds(20);
  // A stream that has sent no Hello after this time ends with DEADLINE_EXCEEDED.
  int64_t hello_patience_ns = 10'000'000'000;
  // If the store has not answered a Hello after this time, the session begins without its evidence.
  // A client waits ten seconds for the welcome.
  int64_t load_patience_ns = 5'000'000'000;
  // A client that does not read its last messages for this long is disconnected.
  int64_t close_patience_ns = 2'000'000'000;
  // The maximum number of streams of one connection; the next one waits.
  uint32_t max_streams_per_connection = 100;
  // The maximum memory of all connections' buffers; beyond it reads are slowed down.
  uint64_t memory_quota_bytes = 64ull << 20;
  // A draining daemon asks its clients to come back after this delay, spread so that the next
  // daemon gets no more than `reconnects_per_s` at a time. The clients add their jitter.
  uint32_t reconnect_delay_ms = 500;
  uint32_t reconnects_per_s = 500;
  bool reflection = false;
  // What it serves TLS with. It serves plain text without a certificate, and asks clients for one
  // where there is a `ca`. The files are read again every second.
  tls::Files tls;
  // Told how late each timer of the decision loop ran, on the loop's thread. May be empty.
  std::function<void(std::chrono::nanoseconds)> on_timer;
};

// The value of a frame or shadow visit that nobody can have measured (message_validation.h).
enum class RejectionReason : size_t {
  kFrameTime,
  kDetectionTime,
  kBuildTime,
  kCheckCount,
  kNativeBytes,
};
inline constexpr std::array<std::string_view, 5> kRejectionReasonNames = {
    "frame_time", "detection_time", "build_time", "check_count", "native_bytes"};
using RejectionCounts = std::array<std::atomic<uint64_t>, kRejectionReasonNames.size()>;

// Counts of events since the daemon's start, and of what is open now. The services' threads write
// them and any thread may read them. Each counter is exact, but several are not read at one moment.
struct Counters {
  std::atomic<uint64_t> open_stream_count{0};   // streams that are open now
  std::atomic<uint64_t> open_watcher_count{0};  // watchers that are connected now
  std::atomic<uint64_t> session_count{0};       // sessions in memory, connected or lost
  // Connections that were ended because they had begun far more calls than streams they may have.
  std::atomic<uint64_t> flooding_connection_count{0};
  std::atomic<uint64_t> connected_stream_count{0};  // streams that got a welcome
  std::atomic<uint64_t> resumed_count{0};           // connected streams that resumed a session
  // Sessions that began without evidence that the store could not read.
  std::atomic<uint64_t> degraded_start_count{0};
  std::atomic<uint64_t> goodbye_count{0};            // sessions that the client ended
  std::atomic<uint64_t> malformed_message_count{0};  // messages that could not be parsed
  std::atomic<uint64_t> invalid_message_count{0};    // messages that broke a rule of the contract
  // Messages of a newer protocol, which were not applied.
  std::atomic<uint64_t> unknown_message_count{0};
  // Messages whose sequence number was applied before.
  std::atomic<uint64_t> replayed_message_count{0};
  std::atomic<uint64_t> applied_message_count{0};
  // Frames and shadow visits; those that are rejected by what is wrong with them, a
  // RejectionReason.
  std::atomic<uint64_t> accepted_frame_count{0};
  RejectionCounts rejected_frame_counts{};
  std::atomic<uint64_t> accepted_shadow_count{0};
  RejectionCounts rejected_shadow_counts{};
  // Bail-outs beyond what a game, or the games of a token or address, can have: they were answered,
  // and are no evidence.
  std::atomic<uint64_t> surplus_bail_out_count{0};
  std::atomic<uint64_t> dropped_frame_count{0};  // the clients report what their queues dropped
  std::atomic<uint64_t> decision_count{0};
  std::atomic<uint64_t> switch_command_count{0};
  std::atomic<uint64_t> refused_switch_count{0};  // commands that a client did not execute
  std::atomic<uint64_t> stored_commit_count{0};
  std::atomic<uint64_t> failed_commit_count{0};
  std::atomic<uint64_t> waiting_audit_bytes{0};  // of audit rows that wait for the disk now
  // Audit rows that are not in the log, because too many waited or the store could not write them.
  std::atomic<uint64_t> lost_audit_row_count{0};
  // Calls and streams that ended with an error, by v1::ErrorReason. A client that went away is
  // none.
  std::array<std::atomic<uint64_t>, v1::ErrorReason_ARRAYSIZE> error_counts{};
};

}  // namespace sweepstake::rpc
