// Turns the content of the queue into the messages of a session. Runs on the sender thread.
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

// Collects frames into columnar batches. A batch is due after an interval, a number of frames, or a
// number of bytes, whichever comes first.
//
// The caller passes the time. Not thread-safe. Memory: one batch.
class FrameBatcher {
 public:
  static constexpr size_t kMaxShadows = 64;

  explicit FrameBatcher(const BatchLimits& limits) : limits_(limits) {}

  // Sets the limits from the next frame on. The current batch may already exceed them.
  void SetLimits(const BatchLimits& limits) { limits_ = limits; }

  // Returns false if the current batch must be taken first, because it is full or the frame does
  // not directly follow its last one.
  bool Fits(const FrameSample& sample) const;
  // REQUIRES: Fits.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // Sets the descriptor of the current batch or, if it is empty, of the next one. The latest
  // descriptor wins.
  void SetDescriptor(const SceneDescriptor& descriptor);
  // Returns whether the current batch, or the next one if it is empty, has room for another visit
  // of the shadow lane. A batch holds at most kMaxShadows visits, in at most half of its bytes.
  bool TakesShadow() const;
  // REQUIRES: TakesShadow.
  void AddShadow(const ShadowSample& sample);

  bool empty() const { return batch_.frames.empty(); }
  bool Due(uint64_t now_ns) const;
  // Takes the current batch. REQUIRES: !empty().
  protocol::FrameBatch Take();

 private:
  bool Full() const;

  BatchLimits limits_;
  protocol::FrameBatch batch_;
  uint32_t batch_bytes_ = 0;
  uint32_t shadow_bytes_ = 0;      // the visits' share of batch_bytes_
  uint64_t begun_ns_ = 0;          // arrival of the first frame of the batch
  uint64_t next_frame_index_ = 0;  // index of the frame after the latest one
};

// Takes the items of the queue in order and encodes them as messages.
//
// Frames go through the batcher. Switch outcomes and mode changes first end the current batch, so
// that the daemon receives everything in the order in which it happened. A frame over the bail-out
// limit also ends its batch, and is reported at once. The shadow lane's samples are sent with the
// next batch. Not thread-safe; the intake is the queue's only consumer.
class EvidenceIntake {
 public:
  // The queue and the state must outlive the intake.
  EvidenceIntake(SampleQueue& queue, ResumableSession& state, const BatchLimits& limits)
      : queue_(queue), state_(state), batcher_(limits) {}

  void SetLimits(const BatchLimits& limits) { batcher_.SetLimits(limits); }

  // Takes items until the queue is empty, and returns true. Returns false if the session is full
  // first; the queue then drops its oldest items when it is full too.
  bool Pump(uint64_t now_ns);
  // Ends the current batch. REQUIRES: the session is not full.
  void Flush();
  bool batch_empty() const { return batcher_.empty(); }

 private:
  void TakeShadows();
  void Take(const QueuedItem& item, uint64_t now_ns);
  void TakeFrame(const FrameSample& sample, uint64_t now_ns);

  SampleQueue& queue_;
  ResumableSession& state_;
  FrameBatcher batcher_;
};

}  // namespace sweepstake
