// The content of a swp_session: the frame path, the queue that it fills, and the consumer that
// empties the queue.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <span>

#include "engine_client/c_api/boundary.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/telemetry/embedded/decider_loop.h"
#include "sweepstake/adaptive_broad_phase.h"

// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): grouped by thread, one per game.
struct swp_session {
  explicit swp_session(uint32_t queue_frames) : queue(queue_frames) {}

  sweepstake::SampleQueue queue;
  std::unique_ptr<sweepstake::Executor> executor;
  // Ends before the queue, its sink, and the executor.
  std::unique_ptr<sweepstake::AdaptiveBroadPhase> adaptive;
  uint64_t settling_ns = 0;

  // Frame thread.
  bool in_frame = false;  // between begin_frame and end_frame
  std::optional<std::span<const sweepstake::OverlapPair>> pairs;  // absent: none to copy

  // Transport thread.
  std::deque<sweepstake::SwitchOutcome> outcomes;
  std::atomic<uint64_t> dropped_outcome_count = 0;  // read by any thread
  sweepstake::SceneDescriptor descriptor;
  std::optional<sweepstake::DeciderLoop> decider_loop;  // absent: no decider is attached
};
