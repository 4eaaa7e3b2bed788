// Step 6: what the frame path produces, on its way from the frame thread to one sender thread.
//
// A FrameSink that never waits: full queues drop their oldest element and count it. Frames have a
// queue of their own; the rarer notes (descriptors, switch outcomes, mode changes) carry the number
// of frames pushed before them, so that Pop returns everything in the order it happened.
//
// What the shadow lane measured has a queue of its own, in no order with the others.
//
// Thread safety: OnShadow on the lane's thread, the sink's other calls and OnModeChange on the
// frame thread, Pop and PopShadow on the sender thread, the counts on any. Memory: 80 bytes per
// frame of capacity, allocated once. Cost: some 10 ns per frame, no allocation, no system call.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "engine_client/telemetry/lossy_ring.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

// A change of mode, as the session was told.
struct ModeNote {
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
};

using QueuedItem = std::variant<FrameSample, SceneDescriptor, SwitchOutcome, ModeNote>;

class SampleQueue final : public FrameSink {
 public:
  // Notes kept. A scene makes one descriptor per 256 frames and a switch per many, so that they
  // outlast the frames.
  static constexpr uint32_t kNoteCapacity = 256;
  static constexpr uint32_t kFrameCapacityMax = 1 << 20;
  // Visits kept: eight sweeps over 32 arms, which at the lane's least interval take two seconds.
  static constexpr uint32_t kShadowCapacity = 256;

  // REQUIRES: frame_capacity is a power of two, 2 to kFrameCapacityMax.
  explicit SampleQueue(uint32_t frame_capacity)
      : frames_(frame_capacity), notes_(kNoteCapacity), shadows_(kShadowCapacity) {}

  void OnFrame(const FrameSample& sample) noexcept override { frames_.Push(sample); }
  void OnDescriptor(const SceneDescriptor& descriptor) noexcept override;
  void OnSwitch(const SwitchOutcome& outcome) noexcept override;
  void OnShadow(const ShadowSample& sample) noexcept override { shadows_.Push(sample); }
  void OnModeChange(const ModeNote& change) noexcept;

  // The next item in the order they happened; absent: nothing is left.
  std::optional<QueuedItem> Pop();
  // The oldest visit of the shadow lane.
  std::optional<ShadowSample> PopShadow() { return shadows_.Pop(); }

  uint64_t dropped_frame_count() const { return frames_.lost_count(); }
  uint64_t dropped_note_count() const { return notes_.lost_count(); }

 private:
  enum class NoteKind : uint32_t { kDescriptor, kSwitch, kMode };

  struct Note {
    uint64_t frames_before;
    NoteKind kind;
    uint32_t reserved;
    uint64_t payload[5];
  };

  template <typename Payload>
  void PushNote(NoteKind kind, const Payload& payload) noexcept;
  QueuedItem TakeNote();

  LossyRing<FrameSample> frames_;
  LossyRing<Note> notes_;
  LossyRing<ShadowSample> shadows_;
  std::optional<Note> next_note_;  // popped from notes_, waiting for the frames before it
};

}  // namespace sweepstake
