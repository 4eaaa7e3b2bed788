// Converts the content of a session's queue to messages. Runs on the sender thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/telemetry/protocol/messages.h"
#include "engine_client/telemetry/protocol/resumable_session.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

struct BatchLimits {
  uint64_t interval_ns = 250'000'000;
  uint32_t frames = 30;
  uint32_t bytes = 16 * 1024;
};

// Collects frames into batches, which are sent column by column. A batch is due when the interval,
// the number of frames or the number of bytes of its limits is reached, whichever comes first.
//
// The caller passes the time. Not thread-safe. Memory: one batch.
class FrameBatcher {
 public:
  static constexpr size_t kMaxShadows = 64;

  explicit FrameBatcher(const BatchLimits& limits) : limits_(limits) {}

  // Sets the limits, which apply from the next frame on. The current batch may already exceed them.
  void SetLimits(const BatchLimits& limits) { limits_ = limits; }

  // Returns whether the frame can be added. If not, the current batch must be taken first: it is
  // full, or the frame is not the direct successor of its last frame.
  bool Fits(const FrameSample& sample) const;
  // REQUIRES: Fits.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // Sets the descriptor of the current batch or, if that is empty, of the next one. It replaces an
  // earlier descriptor of the same batch.
  void SetDescriptor(const SceneDescriptor& descriptor);
  // Returns whether another visit of the shadow lane can be added to the current batch (or to the
  // next one if that is empty). A batch has at most kMaxShadows visits, and they take at most half
  // of its bytes.
  bool TakesShadow() const;
  // REQUIRES: TakesShadow.
  void AddShadow(const ShadowSample& sample);

  bool empty() const { return batch_.frames.empty(); }
  bool Due(uint64_t now_ns) const;
  // Returns the current batch and begins a new one. REQUIRES: !empty().
  protocol::FrameBatch Take();

 private:
  bool Full() const;

  BatchLimits limits_;
  protocol::FrameBatch batch_;
  uint32_t batch_bytes_ = 0;
  uint32_t shadow_bytes_ = 0;      // part of batch_bytes_ that visits take
  uint64_t begun_ns_ = 0;          // arrival time of the batch's first frame
  uint64_t next_frame_index_ = 0;  // index of the latest frame + 1
};

// Takes the items of the queue in order and encodes them as messages.
//
// Frames are collected in batches. A switch outcome or a mode change ends the current batch before
// it is encoded, so the daemon receives everything in the order in which it happened. A frame over
// the bail-out limit also ends its batch and is reported at once. Samples of the shadow lane are
// sent with the next batch. Not thread-safe. The intake must be the only consumer of the queue.
class EvidenceIntake {
 public:
  // The queue and the state must outlive the intake.
  EvidenceIntake(SampleQueue& queue, ResumableSession& state, const BatchLimits& limits)
      : queue_(queue), state_(state), batcher_(limits) {}

  void SetLimits(const BatchLimits& limits) { batcher_.SetLimits(limits); }

  // Takes items until the queue is empty, and returns true. Returns false if the session becomes
  // full before that. Items then stay in the queue, which drops its oldest ones when it is full
  // too.
  bool Pump(uint64_t now_ns);
  // Ends the current batch and passes it to the session. REQUIRES: the session is not full.
  void Flush();

 private:
  void TakeShadows();
  void Take(const QueuedItem& item, uint64_t now_ns);
  void TakeFrame(const FrameSample& sample, uint64_t now_ns);

  SampleQueue& queue_;
  ResumableSession& state_;
  FrameBatcher batcher_;
};

}  // namespace sweepstake
