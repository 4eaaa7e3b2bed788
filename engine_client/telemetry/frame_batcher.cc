#include "engine_client/telemetry/frame_batcher.h"

#include <bit>
#include <cassert>
#include <utility>

#include "engine_client/telemetry/wire.h"

namespace sweepstake {
namespace {

// Tags and lengths of the columns, the sequence number and the descriptor, generously.
constexpr uint32_t kBatchOverheadBytes = 160;
constexpr uint32_t kMessageTagBytes = 2;  // and the length of a message within the batch
constexpr uint32_t kShadowBytesMax = kMessageTagBytes + 5 * 11 + 4 * 6;

uint32_t VarintBytes(uint64_t value) {
  return (static_cast<uint32_t>(std::bit_width(value | 1)) + 6) / 7;
}

uint32_t WireBytes(const FrameSample& sample) {
  return VarintBytes(sample.frame_time_ns) + VarintBytes(sample.detection_time_ns) +
         VarintBytes(sample.aabb_check_count) + VarintBytes(sample.pair_count) +
         VarintBytes(sample.native_bytes) + VarintBytes(sample.object_count) +
         VarintBytes(sample.arm) + VarintBytes(sample.switch_epoch) + VarintBytes(sample.flags);
}

}  // namespace

bool FrameBatcher::Fits(const FrameSample& sample) const {
  if (empty()) return true;
  return !Full() && sample.frame_index == next_frame_index_ &&
         kBatchOverheadBytes + batch_bytes_ + WireBytes(sample) <= limits_.bytes;
}

bool FrameBatcher::Full() const {
  return static_cast<uint32_t>(batch_.frame_time_ns_size()) >= limits_.frames;
}

void FrameBatcher::Add(const FrameSample& sample, uint64_t now_ns) {
  assert(Fits(sample));
  if (empty()) {
    begun_ns_ = now_ns;
    batch_.set_first_frame_index(sample.frame_index);
    // What the queue dropped shows as a gap in the numbers.
    if (sample.frame_index > next_frame_index_) {
      batch_.set_dropped_frame_count(sample.frame_index - next_frame_index_);
    }
  }
  batch_.add_frame_time_ns(sample.frame_time_ns);
  batch_.add_detection_time_ns(sample.detection_time_ns);
  batch_.add_aabb_check_count(sample.aabb_check_count);
  batch_.add_pair_count(sample.pair_count);
  batch_.add_native_bytes(sample.native_bytes);
  batch_.add_object_count(sample.object_count);
  batch_.add_arm(sample.arm);
  batch_.add_switch_epoch(sample.switch_epoch);
  batch_.add_flags(sample.flags);
  batch_bytes_ += WireBytes(sample);
  next_frame_index_ = sample.frame_index + 1;
}

void FrameBatcher::SetDescriptor(const SceneDescriptor& descriptor) {
  *batch_.mutable_scene_descriptor() = ToWire(descriptor);
}

bool FrameBatcher::TakesShadow() const {
  return batch_.shadow_samples_size() < kShadowMax &&
         kBatchOverheadBytes + shadow_bytes_ + kShadowBytesMax <= limits_.bytes / 2;
}

void FrameBatcher::AddShadow(const ShadowSample& sample) {
  assert(TakesShadow());
  v1::ShadowSample& wire = *batch_.add_shadow_samples();
  wire = ToWire(sample);
  const auto bytes = kMessageTagBytes + static_cast<uint32_t>(wire.ByteSizeLong());
  shadow_bytes_ += bytes;
  batch_bytes_ += bytes;
}

bool FrameBatcher::Due(uint64_t now_ns) const {
  if (empty()) return false;
  return Full() || now_ns - begun_ns_ >= limits_.interval_ns;
}

v1::FrameBatch FrameBatcher::Take() {
  assert(!empty());
  batch_bytes_ = shadow_bytes_ = 0;
  return std::exchange(batch_, v1::FrameBatch());
}

}  // namespace sweepstake
