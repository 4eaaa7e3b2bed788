#include "engine_client/telemetry/common/sample_queue.h"

#include <cstring>
#include <utility>

namespace sweepstake {

template <typename Payload>
void SampleQueue::PushNote(NoteKind kind, const Payload& payload) noexcept {
  static_assert(std::is_trivially_copyable_v<Payload> && sizeof(Payload) <= sizeof(Note::payload));
  Note note{.frames_before = frames_.pushed_count(), .kind = kind, .reserved = 0, .payload = {}};
  std::memcpy(note.payload, &payload, sizeof(payload));
  notes_.Push(note);
}

void SampleQueue::OnDescriptor(const SceneDescriptor& descriptor) noexcept {
  PushNote(NoteKind::kDescriptor, descriptor);
}

void SampleQueue::OnSwitch(const SwitchOutcome& outcome) noexcept {
  PushNote(NoteKind::kSwitch, outcome);
}

void SampleQueue::OnModeChange(const ModeChange& change) noexcept {
  PushNote(NoteKind::kMode, change);
}

std::optional<QueuedItem> SampleQueue::Pop() {
  // Read the number of frames before the notes. Then every note that is older than one of these
  // frames is already visible in notes_.
  const uint64_t frame_limit = frames_.pushed_count();
  if (!next_note_) next_note_ = notes_.Pop();
  const bool frames_left = frames_.passed_count() < frame_limit;
  if (next_note_ && (!frames_left || next_note_->frames_before <= frames_.passed_count())) {
    return TakeNote();
  }
  if (!frames_left) return std::nullopt;
  return frames_.Pop();
}

QueuedItem SampleQueue::TakeNote() {
  const Note note = *std::exchange(next_note_, std::nullopt);
  const auto unpack = [&note]<typename Payload>(Payload value) {
    std::memcpy(&value, note.payload, sizeof(value));
    return QueuedItem(value);
  };
  switch (note.kind) {
    case NoteKind::kDescriptor:
      return unpack(SceneDescriptor{});
    case NoteKind::kSwitch:
      return unpack(SwitchOutcome{});
    case NoteKind::kMode:
      break;
  }
  return unpack(ModeChange{});
}

}  // namespace sweepstake
