// The limits, intervals and counters of the gRPC services. The options of sessions are in
// server/sessions/common/options.h. Each comment describes what happens at the limit.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/decider/client_reports.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/alerts/alert_options.h"
#include "server/auth/principal.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::history {
class History;
}

namespace sweepstake::rpc {

// Limits of a batch (frames, shadow samples) and of the time scale in a Hello. A message above a
// limit is INVALID_ARGUMENT.
using protocol::kMaxBatchFrames;
inline constexpr uint32_t kMaxBatchShadows = 64;
inline constexpr double kMaxTimeScale = 1000;
// Minimum interval between decisions in a Hello, before its time scale. All games share the
// decision loop and the commits, and each decision uses both.
inline constexpr uint64_t kMinDecisionIntervalNs = 250'000'000;
using protocol::kMaxMessageBytes;
// Number of evidence records per message of an export. An import message with more records is
// INVALID_ARGUMENT.
using protocol::kRecordsPerMessage;
// Maximum number of records of one import. All imports under way may together have twice this
// number. More records are RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxImportRecords = 200'000;
// Maximum number of records in quarantine, where imported evidence waits until it is promoted. An
// import that would exceed it is RESOURCE_EXHAUSTED.
inline constexpr uint64_t kMaxQuarantinedRecords = 1'000'000;
// Audit log: maximum number of segments per message of a listing, and of rows per page of an
// export.
inline constexpr uint32_t kAuditSegmentsPerMessage = 100;
inline constexpr uint32_t kAuditRowsPerPage = 500;
// Maximum number of rows in a page of a listing, and of rows that one call examines for it. A call
// with few matches returns less than a page, because other reads wait for it.
inline constexpr uint32_t kDecisionsPerPage = 100;
inline constexpr uint32_t kRowsPerList = 4'000;
// Maximum number of PriorReader::ScanAudit in one call.
inline constexpr uint32_t kScansPerList = 8;
// A page of a listing ends when its rows reach this size.
inline constexpr size_t kListBytes = 1024 * 1024;
// A message of an audit export is sent when its rows reach this size. It may exceed the size by one
// row.
inline constexpr size_t kAuditBytesPerMessage = 128 * 1024;
// A message of an audit export is also sent when this amount was read to find its rows.
inline constexpr size_t kAuditBytesPerRead = 1024 * 1024;
// Limits the rate of bail-outs that count as evidence, over all sessions of a party
// (AccessControl::BeginHello).
// - Rate: the rate of kBailingOutGames games with one bail-out per DecisionOptions::bail_out_ns,
//   but at least kMinBailOutsPerS per second.
// - Burst: ten seconds of that rate, which exceeds the limit of one session
//   (decision::BailOutBudget).
// - Bail-outs above the limit are answered, but are not evidence.
inline constexpr double kBailingOutGames = 10;
inline constexpr double kMinBailOutsPerS = 2;
// The daemon accepts max_sessions plus this number of streams, because a stream has no session
// while the store is read for its Hello. The next stream is RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxStreamsWithoutSession = 1'000;
inline constexpr uint32_t kScenesPerPage = 100;  // maximum number of scenes per page of a listing
// Maximum number of sessions per page of a listing.
inline constexpr uint32_t kSessionsPerPage = 100;
inline constexpr int64_t kNsPerMs = 1'000'000;

// RpcServer::Adjust changes the Adjustable members; changes take effect at once.
struct RpcOptions : sessions::HostedSessionOptions {
  RpcOptions() { encode_audit_row = EncodeAuditRow; }

  // Saves the updates that the store has not written yet, for instance to a file. It is called on
  // the decision loop with all of these updates:
  // - every five seconds while the store cannot be written,
  // - once after the store has recovered,
  // - at the end of RpcServer::Drain.
  // If it is empty, nothing is called.
  std::function<void(std::vector<priors::SourceUpdate>)> keep_waiting = {};

  alerts::AlertOptions alerts = {};

  // The largest time scale that a Hello may request, 1 to kMaxTimeScale; a larger one is
  // INVALID_ARGUMENT. A session with time scale n decides, commits and learns n times as often.
  sessions::Adjustable<double> max_time_scale = 1;
  // The maximum number of streams from one address that is not on the daemon's own machine; the
  // next stream is RESOURCE_EXHAUSTED. Such an address may have this number plus
  // OpenConnections::kSpare connections; further connections are closed.
  sessions::Adjustable<uint32_t> max_streams_per_address = 2'000;
  // The maximum messages per second of a stream, multiplied by its time scale. The burst is ten
  // seconds of that rate. Above the limit the stream ends with RESOURCE_EXHAUSTED. A client that
  // sends a batch every 250 ms needs 4 messages/s. A game with 10,000 frames/s needs 42, because a
  // batch holds at most kMaxBatchFrames. After a reconnection a client also resends unacknowledged
  // messages.
  sessions::Adjustable<uint32_t> max_messages_per_s = 200;
  // The maximum Hellos per second of a party (AccessControl::BeginHello). The burst is ten seconds
  // of that rate. Above the limit a Hello is RESOURCE_EXHAUSTED.
  // The limit exists because a Hello can cause a read of the store. The burst is enough for 10,000
  // games behind one address that reconnect after a restart.
  sessions::Adjustable<uint32_t> max_hellos_per_s = 1'000;
  // The maximum number of calls per second, per token and per address, without the streams of
  // games. The burst is ten seconds of that rate. Above the limit a call is
  // RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_reads_per_s = 100;
  // The maximum number of exports and imports under way, for the whole daemon and per token; the
  // next one is RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_transfers = 64;
  sessions::Adjustable<uint32_t> max_transfers_per_token = 16;
  // The valid tokens. If null or empty, calls need none. Borrowed; it must outlive
  // the server.
  const auth::TokenDirectory* tokens = nullptr;
  // Whether clients on the daemon's machine are a proxy whose header x-forwarded-for names the real
  // client.
  bool trusts_proxy = false;
  // The maximum number of watchers at a time; the next one is RESOURCE_EXHAUSTED. One token may
  // have at most half of this number, rounded up. So may one address that is not on the daemon's
  // own machine.
  sessions::Adjustable<uint32_t> max_watchers = 256;
  // A watcher that does not read its events for this time is ended with RESOURCE_EXHAUSTED. An
  // export or import that makes no progress for this time ends with DEADLINE_EXCEEDED.
  int64_t watcher_patience_ns = 20'000'000'000;
  // An export or import that has not finished after this time ends with DEADLINE_EXCEEDED, even if
  // it makes progress. For comparison: exporting an audit log of 256 MiB takes ten minutes at 4
  // Mbit/s.
  int64_t transfer_patience_ns = 1'800'000'000'000;
  // A connection is closed if its HTTP/2 handshake, and its TLS handshake if there is a
  // certificate, has not finished after this time.
  std::chrono::milliseconds handshake_patience{10'000};
  // After this time, varied by ±10 %, gRPC asks the client to end the connection. A client whose
  // certificate or authority has become invalid can therefore not stay connected. Calls on the
  // connection have connection_age_grace to finish.
  std::chrono::milliseconds connection_age = std::chrono::minutes(30);
  std::chrono::milliseconds connection_age_grace = std::chrono::minutes(1);
  // gRPC asks the client to end a connection that has had no calls for this time, because opening a
  // connection needs no token. Clients that wait between two calls reconnect by themselves.
  std::chrono::milliseconds connection_idle_patience = std::chrono::minutes(1);
  // A connection that receives nothing for this interval gets a keepalive ping. It is closed if the
  // answer does not arrive within keepalive_patience.
  std::chrono::milliseconds keepalive_interval = std::chrono::minutes(1);
  std::chrono::milliseconds keepalive_patience = std::chrono::seconds(20);
  // When the daemon ends a stream, the client has this time to read the last messages. Then the
  // call is cancelled.
  int64_t close_patience_ns = 2'000'000'000;
  // The maximum number of streams of one connection; the client's next stream waits until another
  // ends.
  uint32_t max_streams_per_connection = 100;
  // The maximum memory of all connections' buffers; above it reads are slowed down.
  uint64_t memory_quota_bytes = 64ull << 20;
  // A draining daemon requests its clients to reconnect after this delay. Each client gets a longer
  // delay than the previous client, so that the next daemon receives at most `reconnects_per_s`
  // connections per second. The clients add their own jitter.
  uint32_t reconnect_delay_ms = 500;
  uint32_t reconnects_per_s = 500;
  bool reflection = false;
  // The history of games; null: there is none. Borrowed; it must outlive the server.
  history::History* history = nullptr;
  // The TLS files. Without a certificate the daemon serves plain text. With a `ca` it requires
  // client certificates. The files are read again every second.
  tls::Files tls;
  // Called on the decision loop's thread for each timer, with the time by which it ran late. It may
  // be an empty function.
  std::function<void(std::chrono::nanoseconds)> on_timer;
};

// Counts of events since the daemon's start, and of streams and watchers that are open now. The
// services' threads write them and any thread may read them. Each counter is exact, but several
// counters cannot be read at one moment.
struct Counters : sessions::SessionCounters {
  std::atomic<uint64_t> open_stream_count{0};   // streams that are open now
  std::atomic<uint64_t> open_watcher_count{0};  // watchers that are connected now
  // Connections and calls that the guard has ended (net/http2_guard.h).
  std::atomic<uint64_t> refused_connection_count{0};
  std::atomic<uint64_t> unread_call_count{0};
  std::atomic<uint64_t> connected_stream_count{0};  // streams that received a welcome message
  std::atomic<uint64_t> resumed_count{0};           // connected streams that resumed a session
  // Sessions that began without some of their stored evidence, because the store could not read it.
  std::atomic<uint64_t> degraded_start_count{0};
  // Sessions of players that began with arms that are not known, about which no evidence is stored.
  std::atomic<uint64_t> unknown_arm_session_count{0};
  // StoreLosses::player_increment_count.
  std::atomic<uint64_t> limited_player_evidence_count{0};
  std::atomic<uint64_t> malformed_message_count{0};  // messages that could not be parsed
  std::atomic<uint64_t> invalid_message_count{0};    // messages that broke a rule of the contract
  // Calls and streams that ended with an error, by v1::ErrorReason. A client that disconnects is
  // not an error.
  std::array<std::atomic<uint64_t>, v1::ErrorReason_ARRAYSIZE> error_counts{};
};

}  // namespace sweepstake::rpc
