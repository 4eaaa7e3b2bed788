// The loop of an embedded decider: it empties the queue that the frame thread fills, makes
// decisions, and posts switch commands. The embedded session runs it on its sender thread. The C
// API runs it on the thread that calls poll.
//
// The decider receives items in the order in which they happened. Not thread-safe. The loop must be
// the only consumer of the queue. Memory: a buffer of 256 frames.
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
  // Borrows the queue and the broad phase. Marks the broad phase as having a decider, and sets its
  // settling time and the use of its shadow lane to the decider's.
  DeciderLoop(SampleQueue& queue, AdaptiveBroadPhase& adaptive,
              std::unique_ptr<EmbeddedDecider> decider);

  // Passes the content of the queue to the decider; returns the number of frames.
  uint64_t TakeQueue(uint64_t now_ns);
  // Makes a decision if one is due. Posts its command, if any, to the broad phase and returns it.
  std::optional<SwitchCommand> Decide(uint64_t now_ns);
  // Returns whether beliefs should be published: a decision was made since the last PublishBeliefs,
  // or PublishBeliefs was never called.
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

// Stores the means of the posteriors in the broad phase. The broad phase uses them to choose an arm
// after a bail-out if no decider is present.
void SetPosteriorMeans(const std::vector<ArmBelief>& beliefs, AdaptiveBroadPhase& adaptive);

}  // namespace sweepstake
