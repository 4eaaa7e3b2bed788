// The limits, intervals and counters of the services, in addition to those of the sessions. Each
// field says what happens at its limit.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/auth/principal.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

inline constexpr uint32_t kProtocolVersion = 1;  // clients with another one are refused
// A message above one of these three limits is INVALID_ARGUMENT.
inline constexpr uint32_t kMaxBatchFrames = 240;
inline constexpr uint32_t kMaxBatchShadows = 64;
inline constexpr double kMaxTimeScale = 1000;
inline constexpr uint32_t kMaxMessageBytes = 256 * 1024;  // a longer message is RESOURCE_EXHAUSTED
// An export sends this many records per message; an import message with more is INVALID_ARGUMENT.
inline constexpr uint32_t kRecordsPerMessage = 200;
// One import has at most this many records, all imports under way together twice as many. More
// records are RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxImportRecords = 200'000;
// Maximum number of records in quarantine. An import that would exceed it is RESOURCE_EXHAUSTED.
inline constexpr uint64_t kMaxQuarantinedRecords = 1'000'000;
// Maximum number of segments per message of a listing, and of rows per page of an export.
inline constexpr uint32_t kAuditSegmentsPerMessage = 100;
inline constexpr uint32_t kAuditRowsPerPage = 500;
// An export message is sent once its rows reach this size; it may exceed the size by one row.
inline constexpr size_t kAuditBytesPerMessage = 128 * 1024;
// Limits the bail-outs that count as evidence, per token, and per address that is not on the
// daemon's own machine, over any number of sessions. The rate is that of kBailingOutGames games
// with a bail-out in every DecisionOptions::bail_out_ns, but at least kMinBailOutsPerS per second.
// The burst is ten seconds of that rate, which exceeds the limit of one session
// (decision::BailOutBudget). Bail-outs above the limit are answered, but are not evidence.
inline constexpr double kBailingOutGames = 10;
inline constexpr double kMinBailOutsPerS = 2;
// Maximum number of streams without a session, in addition to max_sessions. The next stream is
// RESOURCE_EXHAUSTED.
inline constexpr uint32_t kMaxStreamsWithoutSession = 1'000;
inline constexpr uint32_t kScenesPerPage = 100;  // maximum number of scenes per page of a listing
// maximum number of sessions per page of a listing
inline constexpr uint32_t kSessionsPerPage = 100;
inline constexpr int64_t kNsPerMs = 1'000'000;

// RpcServer::Adjust changes the Adjustable members; changes take effect at once.
struct RpcOptions : sessions::HostedSessionOptions {
  RpcOptions() { encode_audit_row = EncodeAuditRow; }

  // Called on the decision loop with all updates that wait for the store: every few seconds while
  // the store cannot be written, once after it has recovered, and at the end of Drain. May be
  // empty.
  std::function<void(std::vector<priors::SourceUpdate>)> keep_waiting = {};

  // The largest time scale that a Hello may request, 1 to kMaxTimeScale; a larger one is
  // INVALID_ARGUMENT. A session decides, commits and learns that many times as often.
  sessions::Adjustable<double> max_time_scale = 1;
  // The maximum number of streams from one address that is not on the daemon's own machine; one
  // more is RESOURCE_EXHAUSTED. Such an address may have OpenConnections::kSpare more connections
  // than streams; further ones are closed.
  sessions::Adjustable<uint32_t> max_streams_per_address = 2'000;
  // The maximum messages per second of a stream, times its time scale, with a burst of ten seconds
  // of that rate. Above it the stream ends with RESOURCE_EXHAUSTED. With the batch interval in
  // Welcome a client sends four; a game of 10,000 frames/s needs 42. After a reconnection a client
  // also resends unacknowledged messages.
  sessions::Adjustable<uint32_t> max_messages_per_s = 200;
  // The maximum Hellos per second, per token and per address that is not on the daemon's own
  // machine, with a burst of ten seconds of that rate. One more is RESOURCE_EXHAUSTED. Each Hello
  // may cost a read of the store. The burst is enough for 10,000 games behind one address that
  // reconnect after a restart.
  sessions::Adjustable<uint32_t> max_hellos_per_s = 1'000;
  // The maximum calls per second that list, export or begin to watch, per token and per address,
  // with a burst of ten seconds of that rate. One more is RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_reads_per_s = 100;
  // The maximum number of exports and imports under way, for the daemon and per token; one more is
  // RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_transfers = 64;
  sessions::Adjustable<uint32_t> max_transfers_per_token = 16;
  // The valid tokens. If null or empty, every caller may do everything. They outlive the server.
  const auth::TokenDirectory* tokens = nullptr;
  // The maximum number of watchers at a time; the next one is RESOURCE_EXHAUSTED. A token, and an
  // address that is not on the daemon's own machine, may have half of them, rounded up.
  sessions::Adjustable<uint32_t> max_watchers = 256;
  // A watcher that does not read for this long is dropped with RESOURCE_EXHAUSTED. An export or
  // import that makes no progress for this long ends with DEADLINE_EXCEEDED.
  int64_t watcher_patience_ns = 20'000'000'000;
  // An export or import that has not finished after this time ends with DEADLINE_EXCEEDED, even if
  // it makes progress. An audit log of 256 MiB takes ten minutes at 4 Mbit/s.
  int64_t transfer_patience_ns = 1'800'000'000'000;
  // A connection is closed if its HTTP/2 handshake, and its TLS handshake if there is a
  // certificate, has not finished after this time.
  std::chrono::milliseconds handshake_patience{10'000};
  // A connection is asked to end after this time, varied by ±10 %, so that a client whose
  // certificate or authority has become invalid does not stay. Its calls have the grace time to
  // finish.
  std::chrono::milliseconds connection_age = std::chrono::minutes(30);
  std::chrono::milliseconds connection_age_grace = std::chrono::minutes(1);
  // A connection without calls is asked to end after this time, because opening one needs no token.
  // Clients that wait between two calls reconnect by themselves.
  std::chrono::milliseconds connection_idle_patience = std::chrono::minutes(1);
  // A connection that receives nothing for this interval gets a keepalive ping. It is closed if the
  // answer does not arrive within the patience.
  std::chrono::milliseconds keepalive_interval = std::chrono::minutes(1);
  std::chrono::milliseconds keepalive_patience = std::chrono::seconds(20);
  // A stream that has sent no Hello after this time ends with DEADLINE_EXCEEDED.
  int64_t hello_patience_ns = 10'000'000'000;
  // A client that does not read its last messages for this long is disconnected.
  int64_t close_patience_ns = 2'000'000'000;
  // The maximum number of streams of one connection; the next one waits.
  uint32_t max_streams_per_connection = 100;
  // The maximum memory of all connections' buffers; above it reads are slowed down.
  uint64_t memory_quota_bytes = 64ull << 20;
  // A draining daemon requests its clients to reconnect after this delay. The delays are spread so
  // that the next daemon gets at most `reconnects_per_s`. The clients add their own jitter.
  uint32_t reconnect_delay_ms = 500;
  uint32_t reconnects_per_s = 500;
  bool reflection = false;
  // The TLS files. Without a certificate the daemon serves plain text. With a `ca` it requires
  // client certificates. The files are read again every second.
  tls::Files tls;
  // Called on the decision loop's thread with the lateness of each timer. May be empty.
  std::function<void(std::chrono::nanoseconds)> on_timer;
};

// Counts of events since the daemon's start, and of streams and watchers that are open now. The
// services' threads write them and any thread may read them. Each counter is exact, but several are
// not read at one moment.
struct Counters : sessions::SessionCounters {
  std::atomic<uint64_t> open_stream_count{0};   // streams that are open now
  std::atomic<uint64_t> open_watcher_count{0};  // watchers that are connected now
  // Connections that were ended because of too many unfinished calls (ConnectionCalls).
  std::atomic<uint64_t> flooding_connection_count{0};
  std::atomic<uint64_t> connected_stream_count{0};  // streams that received a welcome message
  std::atomic<uint64_t> resumed_count{0};           // connected streams that resumed a session
  // Sessions that began without evidence, because the store could not read it.
  std::atomic<uint64_t> degraded_start_count{0};
  std::atomic<uint64_t> malformed_message_count{0};  // messages that could not be parsed
  std::atomic<uint64_t> invalid_message_count{0};    // messages that broke a rule of the contract
  // Calls and streams that ended with an error, by v1::ErrorReason. A client that disconnects is
  // not an error.
  std::array<std::atomic<uint64_t>, v1::ErrorReason_ARRAYSIZE> error_counts{};
};

}  // namespace sweepstake::rpc
