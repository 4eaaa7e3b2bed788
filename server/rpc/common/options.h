// The bounds, intervals and counters of the services, beside those of the sessions that they carry.
// Each field says what happens at its bound.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/telemetry/tls/tls_files.h"
#include "server/auth/principal.h"
#include "server/sessions/common/options.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

// The versions of the protocol that the daemon speaks.
inline constexpr uint32_t kMinProtocolVersion = 1;
inline constexpr uint32_t kMaxProtocolVersion = 2;
// A message beyond one of these three limits is INVALID_ARGUMENT.
inline constexpr uint32_t kMaxBatchFrames = 240;
inline constexpr uint32_t kMaxBatchShadows = 64;
inline constexpr double kMaxTimeScale = 1000;
inline constexpr uint32_t kMaxMessageBytes = 256 * 1024;  // a longer message is RESOURCE_EXHAUSTED
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
struct RpcOptions : sessions::SessionOptions {
  // Called on the decision loop with all that waits for the store, as it is to be committed: every
  // few seconds while that cannot be written, once after it could again, and at the end of Drain.
  // May be empty.
  std::function<void(std::vector<priors::SourceUpdate>)> keep_waiting = {};

  // The largest time scale that a Hello may ask for, 1 to kMaxTimeScale; a larger one is
  // INVALID_ARGUMENT. A session decides, commits and learns that many times as often.
  sessions::Adjustable<double> max_time_scale = 1;
  // The maximum number of streams from one address that is not the daemon's own machine; one more
  // is RESOURCE_EXHAUSTED. Such an address may have open_connections.h's kSpare more connections;
  // one beyond them is closed.
  sessions::Adjustable<uint32_t> max_streams_per_address = 2'000;
  // The maximum messages in a second of a stream, times its time scale, and as many as in ten
  // seconds at once; beyond it the stream ends with RESOURCE_EXHAUSTED. Welcome's batch interval
  // asks for four, a game of 10,000 frames/s needs 42, and one that has come back sends again what
  // was not acknowledged.
  sessions::Adjustable<uint32_t> max_messages_per_s = 200;
  // The maximum Hellos in a second of a token, and of an address that is not the daemon's own
  // machine, and as many as in ten seconds at once; one more is RESOURCE_EXHAUSTED. Each may cost a
  // read of the store. 10,000 games behind one address, which come back after a restart, fit into
  // what it may have at once.
  sessions::Adjustable<uint32_t> max_hellos_per_s = 1'000;
  // The maximum calls in a second of a token, and of an address, that list, export or begin to
  // watch, and as many as in ten seconds at once; one more is RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_reads_per_s = 100;
  // The maximum number of exports and imports under way, of the daemon and of one token; one more
  // is RESOURCE_EXHAUSTED.
  sessions::Adjustable<uint32_t> max_transfers = 64;
  sessions::Adjustable<uint32_t> max_transfers_per_token = 16;
  // The tokens that calls must bring; without, or while there are none, everybody may do
  // everything. They outlive the server.
  const auth::TokenDirectory* tokens = nullptr;
  // The maximum number of watchers at a time; the next one is RESOURCE_EXHAUSTED. A token, and an
  // address that is not the daemon's own machine, may have half of them, rounded up.
  sessions::Adjustable<uint32_t> max_watchers = 256;
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

// Counts of events since the daemon's start, and of what is open now. The services' threads write
// them and any thread may read them. Each counter is exact, but several are not read at one moment.
struct Counters : sessions::SessionCounters {
  std::atomic<uint64_t> open_stream_count{0};   // streams that are open now
  std::atomic<uint64_t> open_watcher_count{0};  // watchers that are connected now
  // Connections that were ended because they had begun far more calls than streams they may have.
  std::atomic<uint64_t> flooding_connection_count{0};
  std::atomic<uint64_t> connected_stream_count{0};  // streams that got a welcome
  std::atomic<uint64_t> resumed_count{0};           // connected streams that resumed a session
  // Sessions that began without evidence that the store could not read.
  std::atomic<uint64_t> degraded_start_count{0};
  std::atomic<uint64_t> malformed_message_count{0};  // messages that could not be parsed
  std::atomic<uint64_t> invalid_message_count{0};    // messages that broke a rule of the contract
  // Calls and streams that ended with an error, by v1::ErrorReason. The departure of a client is
  // not an error.
  std::array<std::atomic<uint64_t>, v1::ErrorReason_ARRAYSIZE> error_counts{};
};

}  // namespace sweepstake::rpc
