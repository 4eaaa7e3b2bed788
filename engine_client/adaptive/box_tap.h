// Copies the boxes of consecutive frames from the frame thread to the shadow lane.
//
// The lane reserves memory and requests a number of frames. The frame thread copies the next frames
// until the request is complete. One atomic word holds two numbers: requested frames and copied
// frames. The frame thread writes the word until all requested frames are copied; after that the
// lane writes it. Memory: slots × objects × 24 bytes.
//
// Thread safety: OnFrame on the frame thread, the other functions on the lane's thread. Cost of
// OnFrame: two loads and a store; while frames are requested, also the copy and two clock readings.
// It never waits, allocates or makes a system call other than the clock.
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

// The data that the frame thread passes with a frame's boxes.
struct FrameNote {
  uint64_t frame_index = 0;
  uint64_t frame_time_ns = 0;  // of the previous frame, because this one has not ended
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

  // Called on each frame. Copies the boxes if a frame is requested. If there are more boxes than
  // reserved, the request ends (too_big_count).
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note, Clock& clock) noexcept;

  // Frees the old memory and allocates memory for `slot_count` frames of up to `object_count`
  // objects. Throws std::bad_alloc and then holds no memory. REQUIRES: complete(), slot_count <=
  // kMaxSlots.
  void Reserve(uint32_t slot_count, size_t object_count);
  // Requests the next `frame_count` frames. REQUIRES: complete(), 1 <= frame_count <= slot_count().
  void Request(uint32_t frame_count);

  // Returns the sum of FrameNote::frame_time_ns over the copied frames. Each counts as at most one
  // second, because a longer frame was a pause.
  uint64_t frame_time_ns() const;
  // Returns the number of frames of the latest request that have been copied.
  uint32_t filled_count() const;
  // Returns whether the request has ended: all frames were copied, or one had too many boxes.
  bool complete() const;
  // Returns the object count of the frame that ended the request because it had too many boxes; 0
  // if no frame did. REQUIRES: complete().
  size_t too_big_count() const { return too_big_count_; }
  // Returns a copied frame. REQUIRES: slot < filled_count().
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

  std::atomic<uint32_t> word_{0};  // requested frames << 8 | copied frames
  std::atomic<uint64_t> latest_frame_{0};
  // Accessed by the frame thread while the request is incomplete, otherwise by the lane.
  std::array<Slot, kMaxSlots> slots_{};
  HookedVector<Aabb> storage_;
  size_t capacity_ = 0;  // maximum number of objects per slot
  uint32_t slot_count_ = 0;
  size_t too_big_count_ = 0;
};

}  // namespace sweepstake
