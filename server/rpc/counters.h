// What the services have seen since the start. Written by their threads, read by any; each counter
// is exact, the set is not one moment's.
#pragma once

#include <atomic>
#include <cstdint>

namespace sweepstake::rpc {

struct Counters {
  std::atomic<uint64_t> connected_stream_count{0};   // streams that got a welcome
  std::atomic<uint64_t> resumed_count{0};            // of those, resumed
  std::atomic<uint64_t> goodbye_count{0};            // sessions that ended in order
  std::atomic<uint64_t> malformed_message_count{0};  // did not parse
  std::atomic<uint64_t> invalid_message_count{0};    // broke a rule of the contract
  std::atomic<uint64_t> replayed_message_count{0};   // sequence at or below one already applied
  std::atomic<uint64_t> applied_message_count{0};
  std::atomic<uint64_t> accepted_frame_count{0};
  std::atomic<uint64_t> rejected_frame_count{0};   // absurd values, see message_validation.h
  std::atomic<uint64_t> dropped_frame_count{0};    // by the clients' queues, as they report
  std::atomic<uint64_t> accepted_shadow_count{0};  // visits of the clients' shadow lanes
  std::atomic<uint64_t> rejected_shadow_count{0};  // absurd values, as above
  std::atomic<uint64_t> decision_count{0};
  std::atomic<uint64_t> switch_command_count{0};
  std::atomic<uint64_t> refused_switch_count{0};  // commands a client did not execute
  std::atomic<uint64_t> stored_commit_count{0};
  std::atomic<uint64_t> failed_commit_count{0};
  // Audit logs that ended before their session since the disk did not keep up.
  std::atomic<uint64_t> cut_audit_log_count{0};
};

}  // namespace sweepstake::rpc
