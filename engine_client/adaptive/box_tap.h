// Copies the boxes of consecutive frames from the frame thread to the shadow lane.
//
// The lane reserves memory and requests a number of frames. The frame thread copies the next frames
// until the request is complete. One atomic word holds the numbers of requested and of copied
// frames: the frame thread writes it while frames are missing, otherwise the lane. Memory: slots ×
// objects × 24 bytes.
//
// Thread safety: OnFrame on the frame thread, the rest on the lane's. Cost of OnFrame: two loads
// and a store; while frames are requested, also the copy and two readings of the clock. It never
// waits, allocates or makes a system call other than the clock.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/aabb.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

// The frame thread's description of a frame.
struct FrameNote {
  uint64_t frame_index = 0;
  uint64_t frame_time_ns = 0;  // the previous frame's time, since this one has not ended
  uint32_t arm = 0;            // the active arm
};

struct TappedFrame {
  FrameNote note;
  std::span<const Aabb> boxes;  // the copied boxes, valid until the next Reserve or Request
  uint64_t copy_time_ns = 0;
};

class BoxTap {
 public:
  static constexpr uint32_t kMaxSlots = kShadowBurstFrames;

  // Copies the boxes if a frame is requested. A frame with more boxes than reserved ends the
  // request.
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note, Clock& clock) noexcept;

  // Allocates memory for `slot_count` frames of up to `object_count` objects; the old memory is
  // freed first. Throws std::bad_alloc and then holds no memory. REQUIRES: complete(), slot_count
  // <= kMaxSlots.
  void Reserve(uint32_t slot_count, size_t object_count);
  // REQUIRES: complete(), 1 <= frame_count <= slot_count().
  void Request(uint32_t frame_count);

  // Returns the sum of the frame times noted with the copied frames. Each counts at most one
  // second: a longer one was a pause.
  uint64_t frame_time_ns() const;
  // Returns the number of frames of the latest request that have been copied.
  uint32_t filled_count() const;
  // Returns whether the request is over: all frames were copied, or one had too many boxes.
  bool complete() const;
  // Returns the object count of the frame that was too big and ended the request; 0 if none was.
  // REQUIRES: complete().
  size_t too_big_count() const { return too_big_count_; }
  // REQUIRES: slot < filled_count().
  TappedFrame frame(uint32_t slot) const;

  uint32_t slot_count() const { return slot_count_; }
  size_t memory_bytes() const { return storage_.capacity() * sizeof(Aabb); }
  // Returns the index of the latest frame, copied or not.
  uint64_t latest_frame_index() const { return latest_frame_.load(std::memory_order_relaxed); }

 private:
  struct Slot {
    FrameNote note;
    size_t object_count = 0;
    uint64_t copy_time_ns = 0;
  };

  std::atomic<uint32_t> word_{0};  // number of requested frames << 8 | number of copied ones
  std::atomic<uint64_t> latest_frame_{0};
  // Accessed by the thread whose turn it is according to the word.
  std::array<Slot, kMaxSlots> slots_{};
  HookedVector<Aabb> storage_;
  size_t capacity_ = 0;  // the number of objects per slot
  uint32_t slot_count_ = 0;
  size_t too_big_count_ = 0;
};

}  // namespace sweepstake
