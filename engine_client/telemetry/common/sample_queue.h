// The queue between the frame thread and the sender thread of a session.
//
// It is a FrameSink that never waits: when it is full, it drops its oldest element and counts it.
// It consists of three rings:
// - frames
// - notes, which are rarer: descriptors, switch outcomes, mode changes. A note stores how many
//   frames were pushed before it, so Pop returns frames and notes in the order in which they
//   happened.
// - samples of the shadow lane, in no particular order relative to the others
//
// Thread safety: OnShadow on the lane's thread, the other functions of the sink on the frame
// thread, Pop and PopShadow on the sender thread, the counts on any thread. Memory: 80 bytes per
// frame of capacity, allocated once. Pushing a frame neither allocates nor makes a system call.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "engine_client/telemetry/common/flight_ring.h"
#include "engine_client/telemetry/common/lossy_ring.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

using QueuedItem = std::variant<FrameSample, SceneDescriptor, SwitchOutcome, ModeChange>;

class SampleQueue final : public FrameSink {
 public:
  // Maximum number of notes. The notes overflow later than the frames, because a scene has only one
  // descriptor per 256 frames and few switches.
  static constexpr uint32_t kNoteCapacity = 256;
  static constexpr uint32_t kMaxFrameCapacity = 1 << 20;
  // Maximum number of visits: eight sweeps over 32 arms. Sweeps are at least 250 ms apart, so the
  // ring holds the visits of two seconds or more.
  static constexpr uint32_t kShadowCapacity = 256;

  // `flight` is the flight recorder's ring, which may be null. REQUIRES: frame_capacity is a power
  // of two, 2 to kMaxFrameCapacity.
  explicit SampleQueue(uint32_t frame_capacity, std::shared_ptr<FlightRing> flight = nullptr)
      : frames_(frame_capacity),
        notes_(kNoteCapacity),
        shadows_(kShadowCapacity),
        flight_(std::move(flight)) {}

  void OnBoxes(std::span<const Aabb> boxes) noexcept override {
    if (flight_ != nullptr) flight_->OnBoxes(boxes);
  }
  void OnFrame(const FrameSample& sample) noexcept override {
    frames_.Push(sample);
    if (flight_ != nullptr) flight_->OnFrame(sample);
  }
  void OnDescriptor(const SceneDescriptor& descriptor) noexcept override;
  void OnSwitch(const SwitchOutcome& outcome) noexcept override;
  void OnShadow(const ShadowSample& sample) noexcept override { shadows_.Push(sample); }
  void OnModeChange(const ModeChange& change) noexcept override;

  // Removes and returns the oldest frame or note. Returns nullopt if there is none.
  std::optional<QueuedItem> Pop();
  // Removes and returns the oldest visit of the shadow lane. Returns nullopt if there is none.
  std::optional<ShadowSample> PopShadow() { return shadows_.Pop(); }

  uint64_t dropped_frame_count() const { return frames_.lost_count(); }
  uint64_t dropped_note_count() const { return notes_.lost_count(); }

 private:
  enum class NoteKind : uint32_t { kDescriptor, kSwitch, kMode };

  struct Note {
    uint64_t frames_before;
    NoteKind kind;
    uint32_t reserved;
    uint64_t payload[7];
  };

  template <typename Payload>
  void PushNote(NoteKind kind, const Payload& payload) noexcept;
  QueuedItem TakeNote();

  LossyRing<FrameSample> frames_;
  LossyRing<Note> notes_;
  LossyRing<ShadowSample> shadows_;
  const std::shared_ptr<FlightRing> flight_;
  // A note that was popped from notes_ but is newer than the next frames; it is returned after
  // them.
  std::optional<Note> next_note_;
};

}  // namespace sweepstake
