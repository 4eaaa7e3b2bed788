// Step 7: collects frames into columnar batches; a batch is due after an interval, a number of
// frames, or a number of bytes, whichever comes first.
//
// Time comes in as an argument. Not thread-safe. Memory: one batch.
#pragma once

#include <cstdint>

#include "sweepstake/frame_sample.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

struct BatchLimits {
  uint64_t interval_ns = 250'000'000;
  uint32_t frames = 30;
  uint32_t bytes = 16 * 1024;
};

class FrameBatcher {
 public:
  static constexpr int kShadowMax = 64;

  explicit FrameBatcher(const BatchLimits& limits) : limits_(limits) {}

  // In force from the next frame on; the batch under way may be over them by what it already holds.
  void SetLimits(const BatchLimits& limits) { limits_ = limits; }

  // False: the batch under way must be taken first, since it is full or the frame does not follow
  // its last one.
  bool Fits(const FrameSample& sample) const;
  // REQUIRES: Fits.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // Goes with the batch under way, or the next one; the latest wins.
  void SetDescriptor(const SceneDescriptor& descriptor);
  // Whether the batch under way, or the next one, may take another visit of the shadow lane: up to
  // kShadowMax, and in at most half of its bytes.
  bool TakesShadow() const;
  // REQUIRES: TakesShadow.
  void AddShadow(const ShadowSample& sample);

  bool empty() const { return batch_.frame_time_ns().empty(); }
  bool Due(uint64_t now_ns) const;
  // The batch under way. REQUIRES: !empty().
  v1::FrameBatch Take();

 private:
  bool Full() const;

  BatchLimits limits_;
  v1::FrameBatch batch_;
  uint32_t batch_bytes_ = 0;
  uint32_t shadow_bytes_ = 0;      // of these
  uint64_t begun_ns_ = 0;          // when the first frame of the batch came
  uint64_t next_frame_index_ = 0;  // after the latest frame
};

}  // namespace sweepstake
