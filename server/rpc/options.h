// The bounds and intervals of the services. What happens at a bound stands at the field.
#pragma once

#include <cstdint>
#include <string>

#include "server/decision/options.h"
#include "server/priors/audit_rows.h"

namespace sweepstake::rpc {

inline constexpr uint32_t kProtocolVersion = 1;
inline constexpr uint32_t kMaxBatchFrames = 240;          // a longer batch is INVALID_ARGUMENT
inline constexpr uint32_t kMaxBatchShadows = 64;          // more are INVALID_ARGUMENT
inline constexpr uint32_t kMaxMessageBytes = 256 * 1024;  // a longer message is RESOURCE_EXHAUSTED
inline constexpr uint32_t kMaxArms = 32;                  // more are INVALID_ARGUMENT
inline constexpr uint32_t kMaxNameBytes = 128;            // a longer name is INVALID_ARGUMENT
inline constexpr double kMaxTimeScale = 1000;             // a larger one is INVALID_ARGUMENT
inline constexpr uint32_t kRecordsPerMessage =
    200;  // of export and import; more are INVALID_ARGUMENT
inline constexpr uint32_t kMaxImportRecords =
    200'000;  // of one import, and twice as many of all under way; more are RESOURCE_EXHAUSTED
inline constexpr uint32_t kAuditSegmentsPerMessage = 100;  // of a listing
inline constexpr uint32_t kAuditRowsPerPage = 500;         // of an export
// An export's message is sent once it has this many bytes of rows, and may exceed it by one row.
inline constexpr size_t kAuditBytesPerMessage = 128 * 1024;
// Audit rows of one session that wait for the disk; then the log of this session ends, since one
// with a gap could not be derived again. 64 of 7 arms: two minutes.
inline constexpr size_t kMaxWaitingAuditBytes = 64 * 1024;
inline constexpr uint32_t kScenesPerPage = 100;     // of a listing; more are not given
inline constexpr uint32_t kWatcherQueueEvents = 4;  // more are dropped and a snapshot follows

struct RpcOptions {
  // Its policy is that of sessions that name none.
  decision::DecisionOptions decision;
  std::string daemon_version = "0.1.0";
  priors::AuditLimits audit;  // of the store; with 0 rows in all no rows are made

  // Sessions in memory, connected or resumable. At the bound the one that was lost longest ago
  // leaves memory (it can still be resumed from the store); when all are connected a new one is
  // RESOURCE_EXHAUSTED.
  uint32_t max_sessions = 20'000;
  // A lost session leaves memory after it; from then on it is resumed from the store.
  int64_t resume_window_ns = 600'000'000'000;
  // Watchers at a time; the next one is RESOURCE_EXHAUSTED.
  uint32_t max_watchers = 256;
  // A watcher that does not read for so long is dropped with RESOURCE_EXHAUSTED.
  int64_t watcher_patience_ns = 20'000'000'000;
  // A client that does not read its last messages for so long is cut off.
  int64_t close_patience_ns = 2'000'000'000;
  // Streams of one connection; the next one waits.
  uint32_t max_streams_per_connection = 100;
  // Memory of all connections' buffers; beyond it reads are slowed.
  uint64_t memory_quota_bytes = 64ull << 20;
  // Reconnect delay that a draining daemon asks for, before the client's jitter.
  uint32_t reconnect_delay_ms = 500;
  bool reflection = false;
};

}  // namespace sweepstake::rpc
