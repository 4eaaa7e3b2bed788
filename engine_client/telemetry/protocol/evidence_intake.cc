#include "engine_client/telemetry/protocol/evidence_intake.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake {
namespace {

// Upper bound, in bytes, of a batch's overhead: tags and lengths of the columns, sequence number,
// frame index and descriptor.
constexpr uint32_t kBatchOverheadBytes = 160;
constexpr uint32_t kMessageTagBytes = 2;  // tag and length of each message within the batch
constexpr uint32_t kMaxShadowBytes = kMessageTagBytes + 5 * 11 + 4 * 6;

uint32_t VarintBytes(uint64_t value) {
  return (static_cast<uint32_t>(std::bit_width(value | 1)) + 6) / 7;
}

uint32_t WireBytes(const FrameSample& sample) {
  return VarintBytes(sample.frame_time_ns) + VarintBytes(sample.detection_time_ns) +
         VarintBytes(sample.aabb_check_count) + VarintBytes(sample.native_bytes) +
         VarintBytes(sample.object_count) + VarintBytes(sample.arm) +
         VarintBytes(sample.switch_epoch) + VarintBytes(sample.flags);
}

// Returns the encoded size. The tag of each field takes one byte.
uint32_t WireBytes(const ShadowSample& sample) {
  return kMessageTagBytes + 9 + VarintBytes(sample.first_frame_index) + VarintBytes(sample.arm) +
         VarintBytes(sample.detection_time_ns) + VarintBytes(sample.build_time_ns) +
         VarintBytes(sample.aabb_check_count) + VarintBytes(sample.native_bytes) +
         VarintBytes(sample.object_count) + VarintBytes(sample.frame_count) +
         VarintBytes(sample.flags);
}

}  // namespace

bool FrameBatcher::Fits(const FrameSample& sample) const {
  if (empty()) return true;
  return !Full() && sample.frame_index == next_frame_index_ &&
         kBatchOverheadBytes + batch_bytes_ + WireBytes(sample) <= limits_.bytes;
}

bool FrameBatcher::Full() const { return batch_.frames.size() >= limits_.frames; }

void FrameBatcher::Add(const FrameSample& sample, uint64_t now_ns) {
  assert(Fits(sample));
  if (empty()) {
    begun_ns_ = now_ns;
    // If the queue dropped frames, the frame indices have a gap. Its size is the number of dropped
    // frames.
    if (sample.frame_index > next_frame_index_)
      batch_.dropped_frame_count = sample.frame_index - next_frame_index_;
  }
  batch_.frames.push_back(sample);
  batch_.invalid_box_count = std::max(batch_.invalid_box_count, sample.invalid_box_count);
  batch_bytes_ += WireBytes(sample);
  next_frame_index_ = sample.frame_index + 1;
}

void FrameBatcher::SetDescriptor(const SceneDescriptor& descriptor) {
  batch_.scene_descriptor = descriptor;
}

bool FrameBatcher::TakesShadow() const {
  return batch_.shadow_samples.size() < kMaxShadows &&
         kBatchOverheadBytes + shadow_bytes_ + kMaxShadowBytes <= limits_.bytes / 2;
}

void FrameBatcher::AddShadow(const ShadowSample& sample) {
  assert(TakesShadow());
  batch_.shadow_samples.push_back(sample);
  shadow_bytes_ += WireBytes(sample);
  batch_bytes_ += WireBytes(sample);
}

bool FrameBatcher::Due(uint64_t now_ns) const {
  if (empty()) return false;
  return Full() || now_ns - begun_ns_ >= limits_.interval_ns;
}

protocol::FrameBatch FrameBatcher::Take() {
  assert(!empty());
  batch_bytes_ = shadow_bytes_ = 0;
  return std::exchange(batch_, {});
}

bool EvidenceIntake::Pump(uint64_t now_ns) {
  TakeShadows();
  while (!state_.full()) {
    const std::optional<QueuedItem> item = queue_.Pop();
    if (!item) {
      if (batcher_.Due(now_ns)) Flush();
      return true;
    }
    Take(*item, now_ns);
  }
  return false;
}

void EvidenceIntake::TakeShadows() {
  while (batcher_.TakesShadow()) {
    const std::optional<ShadowSample> sample = queue_.PopShadow();
    if (!sample) return;
    batcher_.AddShadow(*sample);
  }
}

void EvidenceIntake::Take(const QueuedItem& item, uint64_t now_ns) {
  if (const auto* sample = std::get_if<FrameSample>(&item)) return TakeFrame(*sample, now_ns);
  if (const auto* descriptor = std::get_if<SceneDescriptor>(&item)) {
    return batcher_.SetDescriptor(*descriptor);
  }
  Flush();
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item))
    state_.Append({protocol::Encode(*outcome)});
  if (const auto* change = std::get_if<ModeChange>(&item))
    state_.Append({protocol::Encode(*change)});
}

void EvidenceIntake::TakeFrame(const FrameSample& sample, uint64_t now_ns) {
  if (!batcher_.Fits(sample)) Flush();
  batcher_.Add(sample, now_ns);
  if ((sample.flags & kFrameBailOut) != 0) {
    Flush();
    state_.Append({protocol::Encode(protocol::BailOut{sample})});
  } else if (batcher_.Due(now_ns)) {
    Flush();
  }
}

void EvidenceIntake::Flush() {
  if (batcher_.empty()) return;
  const protocol::FrameBatch batch = batcher_.Take();
  const FrameSample& first = batch.frames.front();
  state_.Append({.message = protocol::Encode(batch),
                 .frame_count = static_cast<uint32_t>(batch.frames.size()),
                 .active_arm = first.arm,
                 .switch_epoch = first.switch_epoch});
}

}  // namespace sweepstake
