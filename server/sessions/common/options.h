// The limits and counters of sessions. Each comment describes what happens at the limit.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <string_view>

#include "engine_client/decider/options.h"
#include "server/sessions/common/adjustable.h"

namespace sweepstake::decision {
struct AuditRow;
}  // namespace sweepstake::decision

namespace sweepstake::sessions {

struct SessionIdentity;
struct SessionUse;

// The largest box view that is requested from a game, in bytes; a larger one is INVALID_ARGUMENT.
inline constexpr size_t kMaxBoxViewBytes = 64 * 1024;
inline constexpr uint64_t kMaxFrameNs = 3'600'000'000'000;  // an hour; longer frames are rejected
// The maximum bytes of audit rows that wait for the disk, per session (64 rows of a session with 7
// arms, about two minutes of decisions) and over all sessions. Rows above the limit are lost and
// counted.
inline constexpr size_t kMaxWaitingAuditBytesOfSession = 64 * 1024;
inline constexpr size_t kMaxWaitingAuditBytes = 64 * 1024 * 1024;

// The options of the sessions of a daemon. Members of the type Adjustable can change at any time.
struct HostedSessionOptions {
  // decision.policy applies to sessions whose Hello names no policy.
  decision::DecisionOptions decision;
  std::string daemon_version;  // version of the program, as in Welcome and the audit log
  // Whether new sessions write rows of the audit log.
  Adjustable<bool> keeps_audit = true;
  // Encodes an audit row as the bytes that the store keeps.
  std::function<std::string(const decision::AuditRow&)> encode_audit_row;
  // Receives what a session ran, at least every UseMeter::kStepMs while its game sends frames.
  // Called on the decision loop. May be empty.
  std::function<void(const SessionIdentity&, SessionUse)> on_use;
  // Whether other daemons write to the same store. If so, a session that cannot be read from the
  // store is refused. It might have continued in another daemon, and then messages that its client
  // resends would count twice.
  bool shares_store = false;
  // The maximum number of sessions in memory, connected or resumable. At the limit, the session
  // that lost its connection first leaves memory, but it can still be resumed from the store. If
  // all sessions are connected, a new session is RESOURCE_EXHAUSTED. In both limits, a session
  // counts once per SessionTable::kArmsPerPlace arms.
  Adjustable<uint32_t> max_sessions = 20'000;
  // The maximum number of sessions per party of a token (SourceOrigin::owner). At this limit, a
  // session of the party that has lost its connection leaves memory. If there is none, a new
  // session is RESOURCE_EXHAUSTED. The default leaves half of max_sessions to others.
  Adjustable<uint32_t> max_sessions_per_party = 10'000;
  // The maximum number of stored projects. A Hello or an import that would exceed it is
  // RESOURCE_EXHAUSTED. For a Hello, the projects of sessions in memory that are not stored yet
  // count too.
  Adjustable<uint32_t> max_projects = 100;
  // The maximum number of scene names per project. A Hello or an import that would exceed it is
  // RESOURCE_EXHAUSTED.
  Adjustable<uint32_t> max_scenes = 1'000;
  // The secret of all resume tokens: 32 random bytes. If it changes, sessions that began before the
  // change cannot be resumed.
  std::string resume_secret;
  // Generates the ids and seeds of new sessions. Called on the decision loop.
  std::function<uint64_t()> random_bits = [] {
    std::random_device device;
    return (uint64_t{device()} << 32) | device();
  };
  // A session that has lost its connection leaves memory after this time. From then on it can only
  // be resumed from the store.
  Adjustable<int64_t> resume_window_ns = 600'000'000'000;
  // If the store has not answered the read for a Hello after this time, the session begins without
  // stored evidence. The time must be below ten seconds, for which a client waits for the Welcome.
  int64_t load_patience_ns = 5'000'000'000;
};

// The field with the impossible value, in a frame or a shadow visit (rejection.h).
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

// Counts of events since the daemon's start, and present numbers such as sessions in memory. The
// decision loop writes them and any thread may read them. Each counter is exact, but several
// counters cannot be read at one moment.
struct SessionCounters {
  std::atomic<uint64_t> session_count{0};  // sessions in memory, connected or lost
  std::atomic<uint64_t> goodbye_count{0};  // sessions that the client ended
  // Messages of a newer protocol, which were not applied.
  std::atomic<uint64_t> unknown_message_count{0};
  // Messages whose sequence number had already been applied.
  std::atomic<uint64_t> replayed_message_count{0};
  std::atomic<uint64_t> applied_message_count{0};
  // Accepted and rejected frames and shadow visits, the rejected ones by RejectionReason.
  std::atomic<uint64_t> accepted_frame_count{0};
  // Accepted frames that do not count as evidence, because the game was suspended.
  std::atomic<uint64_t> suspended_frame_count{0};
  // Batches of frames in which some objects had invalid boxes.
  std::atomic<uint64_t> invalid_box_batch_count{0};
  RejectionCounts rejected_frame_counts{};
  std::atomic<uint64_t> accepted_shadow_count{0};
  RejectionCounts rejected_shadow_counts{};
  // Bail-outs that were answered but not used as evidence, because the game, or the games of a
  // token or address, exceeded their limit.
  std::atomic<uint64_t> surplus_bail_out_count{0};
  std::atomic<uint64_t> dropped_frame_count{0};  // frames that the clients' queues dropped
  std::atomic<uint64_t> decision_count{0};
  std::atomic<uint64_t> switch_command_count{0};
  std::atomic<uint64_t> refused_switch_count{0};  // commands that a client did not execute
  std::atomic<uint64_t> stored_commit_count{0};
  std::atomic<uint64_t> failed_commit_count{0};
  std::atomic<uint64_t> waiting_audit_bytes{0};  // bytes of audit rows that wait for the disk now
  // Rows that are missing in the audit log, because too many rows waited for the disk or the store
  // could not write them.
  std::atomic<uint64_t> lost_audit_row_count{0};
};

}  // namespace sweepstake::sessions
