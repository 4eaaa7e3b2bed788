// The content of a session: the frame path, the queue that the frame path fills, and the consumer
// that empties the queue (a decider or a link).
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/c_api/live.h"
#include "engine_client/telemetry/common/decider_loop.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake::c_api {

// The part of a link that its session accesses. The session and the link point to each other, and
// whichever is destroyed first clears the other's pointer. Either may be first, because a garbage
// collector runs finalizers in any order.
struct LinkedSession {
  // Held during every call of the link, so that the session does not end during the call.
  std::mutex mutex;
  const uint64_t process_id = ProcessId();
  std::atomic<swp_session*> session;  // null: the session has ended
};

// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): grouped by thread, one per game.
struct LiveSession {
  static constexpr swp_kind kKind = SWP_KIND_SESSION;
  static constexpr std::string_view kName = "session";

  explicit LiveSession(uint32_t queue_frames) : queue(queue_frames) {}
  ~LiveSession() {
    LinkedSession* const attached = link;
    if (attached == nullptr) return;
    std::unique_lock lock(attached->mutex, std::defer_lock);
    // In a forked child, a thread of the parent may hold the mutex for ever.
    if (attached->process_id == ProcessId()) lock.lock();
    attached->session = nullptr;
  }

  SampleQueue queue;
  std::unique_ptr<Executor> executor;
  // Destroyed before the queue and the executor, because it uses both.
  std::unique_ptr<AdaptiveBroadPhase> adaptive;
  // The caller's limits. `adaptive` gets them again when a link ends (its daemon sets others).
  uint64_t settling_ns = 0;
  uint64_t bail_out_ns = 0;

  // Used by the frame thread.
  bool in_frame = false;                              // between begin_frame and end_frame
  std::optional<std::span<const OverlapPair>> pairs;  // absent: this frame has not searched

  // Used by the thread that polls the decider or drives the link.
  std::optional<DeciderLoop> decider_loop;     // absent: no decider is attached
  std::atomic<LinkedSession*> link = nullptr;  // null: no link is attached
};

inline RewardWeights ToWeights(const swp_reward_weights& given) {
  return {given.fps, given.detection, given.memory, given.checks};
}

// Copies the beliefs to the caller's array, which has `capacity` elements. Sets `count` even if the
// array is too small.
inline swp_result GiveBeliefs(std::span<const ArmBelief> known, swp_belief* beliefs,
                              uint32_t capacity, uint32_t* count) noexcept {
  *count = static_cast<uint32_t>(known.size());
  if (known.size() > capacity) return TooFewPlaces();
  for (size_t i = 0; i < known.size(); ++i) beliefs[i] = {known[i].alpha, known[i].beta};
  return SWP_OK;
}

}  // namespace sweepstake::c_api

struct swp_session final : sweepstake::c_api::Handle<sweepstake::c_api::LiveSession> {
  using Handle::Handle;
};
