// Step 7 on the sender thread: takes what is queued, in order, and makes messages of it for the
// session.
//
// Frames go through the batcher; everything else first ends the batch under way, so that the daemon
// sees things in the order they happened. A frame over the bail-out limit ends its batch too and is
// reported at once. What the shadow lane measured goes with the next batch. Not thread-safe; the
// queue's consumer.
#pragma once

#include <cstdint>

#include "engine_client/telemetry/frame_batcher.h"
#include "engine_client/telemetry/sample_queue.h"
#include "engine_client/telemetry/session_state.h"

namespace sweepstake {

class EvidenceIntake {
 public:
  // Both are borrowed.
  EvidenceIntake(SampleQueue& queue, SessionState& state, const BatchLimits& limits)
      : queue_(queue), state_(state), batcher_(limits) {}

  void SetLimits(const BatchLimits& limits) { batcher_.SetLimits(limits); }

  // Takes items until the queue is empty (true) or the session is full (false: the queue then drops
  // its oldest).
  bool Pump(uint64_t now_ns);
  // Ends the batch under way. Only while the session is not full.
  void Flush();
  bool batch_empty() const { return batcher_.empty(); }

 private:
  void TakeShadows();
  void Take(const QueuedItem& item, uint64_t now_ns);
  void TakeFrame(const FrameSample& sample, uint64_t now_ns);

  SampleQueue& queue_;
  SessionState& state_;
  FrameBatcher batcher_;
};

}  // namespace sweepstake
