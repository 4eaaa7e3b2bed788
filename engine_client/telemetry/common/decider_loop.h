// The loop of an embedded decider: it empties the queue that the frame thread fills, decides, and
// posts the switch command. The embedded session runs it on its sender thread; the C API runs it on
// the thread that polls.
//
// Items reach the decider in the order in which they happened. Not thread-safe; the loop is the
// queue's only consumer. Memory: a buffer of 256 frames.
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
  // The queue and the broad phase are borrowed. The constructor marks the broad phase as having a
  // decider and sets its settling time to that of the decider.
  DeciderLoop(SampleQueue& queue, AdaptiveBroadPhase& adaptive,
              std::unique_ptr<EmbeddedDecider> decider);

  // Passes the content of the queue to the decider; returns the number of frames.
  uint64_t TakeQueue(uint64_t now_ns);
  // Makes the decision that is due, if any, and posts its command, which is also returned.
  std::optional<SwitchCommand> Decide(uint64_t now_ns);
  // Returns whether a decision was made since the latest PublishBeliefs, or none was published yet.
  bool has_news() const { return decider_->decision_count() != published_decision_count_; }
  // Publishes the posterior means, the verdict and the latest decision to the broad phase.
  void PublishBeliefs();

  EmbeddedDecider& decider() { return *decider_; }
  const EmbeddedDecider& decider() const { return *decider_; }

 private:
  void Take(const QueuedItem& item, uint64_t now_ns);
  void FlushFrames(uint64_t now_ns);

  SampleQueue& queue_;
  AdaptiveBroadPhase& adaptive_;
  const std::unique_ptr<EmbeddedDecider> decider_;
  std::vector<FrameSample> frames_;  // frames not yet passed to the decider; the memory is reused
  uint64_t frame_count_ = 0;         // frames passed to the decider by the current TakeQueue
  uint64_t published_decision_count_ = ~uint64_t{0};
};

// Passes the means of the posteriors to the broad phase, which uses them for bail-outs while no
// decider is present.
void SetPosteriorMeans(const std::vector<ArmBelief>& beliefs, AdaptiveBroadPhase& adaptive);

}  // namespace sweepstake
