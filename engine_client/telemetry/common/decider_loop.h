// The loop of an embedded decider: it takes what the frame thread queued, decides, and posts the
// command. The embedded session runs it on its sender thread; the C API runs it on the thread that
// polls.
//
// Everything is passed on in the order in which it happened. Not thread-safe; it is the queue's
// consumer. Memory: a buffer of 256 frames.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine_client/telemetry/common/sample_queue.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake {

class DeciderLoop {
 public:
  // The queue and the broad phase are borrowed; the latter is told that a decider is
  // present, and takes over its settling time.
  DeciderLoop(SampleQueue& queue, AdaptiveBroadPhase& adaptive,
              std::unique_ptr<EmbeddedDecider> decider);

  // Passes the content of the queue to the decider; returns the number of frames.
  uint64_t TakeQueue(uint64_t now_ns);
  // Makes the decision that is due, if any, and posts its command, which is also returned.
  std::optional<SwitchCommand> Decide(uint64_t now_ns);
  // Returns whether a decision was made since the latest PublishBeliefs, or none was published yet.
  bool has_news() const { return decider_->decision_count() != published_decision_count_; }
  // Tells the broad phase the posterior means, the verdict and the latest decision.
  void PublishBeliefs();

  EmbeddedDecider& decider() { return *decider_; }
  const EmbeddedDecider& decider() const { return *decider_; }

 private:
  void Take(const QueuedItem& item, uint64_t now_ns);
  void FlushFrames(uint64_t now_ns);

  SampleQueue& queue_;
  AdaptiveBroadPhase& adaptive_;
  const std::unique_ptr<EmbeddedDecider> decider_;
  std::vector<FrameSample> frames_;  // frames not yet handed on; the memory is reused
  uint64_t frame_count_ = 0;         // handed on by the TakeQueue under way
  uint64_t published_decision_count_ = ~uint64_t{0};
};

// Passes the means of the posteriors on, for bail-outs while no decider is present.
void SetPosteriorMeans(const std::vector<ArmBelief>& beliefs, AdaptiveBroadPhase& adaptive);

}  // namespace sweepstake
