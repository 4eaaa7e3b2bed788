// Copies of consecutive frames' boxes, on their way from the frame thread to the shadow lane.
//
// The lane reserves memory and requests a number of frames; the frame thread copies the next ones
// as they come, and nothing at all while nothing is requested. One atomic word says how many are
// requested and how many are there; only the frame thread writes it while some are missing, only
// the lane while none is. Memory: slots × objects × 24 bytes.
//
// Thread safety: OnFrame on the frame thread, the rest on the lane's. Cost of OnFrame: two loads
// and a store; while frames are requested, the copy and two readings of the clock. It never waits,
// allocates or calls the system beyond the clock.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/adaptive/shadow_schedule.h"
#include "sweepstake/aabb.h"
#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {

// What the frame thread knows about a frame that it offers.
struct FrameNote {
  uint64_t frame_index = 0;
  uint64_t frame_time_ns = 0;  // of the frame before: this one has not ended yet
  uint32_t arm = 0;            // active
};

struct TappedFrame {
  FrameNote note;
  std::span<const Aabb> boxes;  // valid until the next Reserve or Request
  uint64_t copy_time_ns = 0;
};

class BoxTap {
 public:
  static constexpr uint32_t kSlotMax = kShadowBurstFrames;

  // Copies the boxes where a frame is requested. Boxes over the reserved count end the request.
  void OnFrame(std::span<const Aabb> boxes, const FrameNote& note, Clock& clock) noexcept;

  // Memory for `slot_count` frames of up to `object_count` objects; what was there is freed first.
  // Throws std::bad_alloc, and then has none. REQUIRES: complete(), slot_count <= kSlotMax.
  void Reserve(uint32_t slot_count, size_t object_count);
  // REQUIRES: complete(), 1 <= frame_count <= slot_count().
  void Request(uint32_t frame_count);

  // Frames of the latest request that are there.
  uint32_t filled_count() const;
  // Nothing is requested any more: all frames are there, or one was too big.
  bool complete() const;
  // Objects of the frame that did not fit and so ended the request; 0: none. REQUIRES: complete().
  size_t too_big_count() const { return too_big_count_; }
  // REQUIRES: slot < filled_count().
  TappedFrame frame(uint32_t slot) const;

  uint32_t slot_count() const { return slot_count_; }
  size_t memory_bytes() const { return storage_.capacity() * sizeof(Aabb); }
  // Of the latest frame, copied or not.
  uint64_t latest_frame_index() const { return latest_frame_.load(std::memory_order_relaxed); }

 private:
  struct Slot {
    FrameNote note;
    size_t object_count = 0;
    uint64_t copy_time_ns = 0;
  };

  std::atomic<uint32_t> word_{0};  // requested << 8 | filled
  std::atomic<uint64_t> latest_frame_{0};
  // Whose turn it is, by the word.
  std::array<Slot, kSlotMax> slots_{};
  std::vector<Aabb> storage_;
  size_t capacity_ = 0;  // objects per slot
  uint32_t slot_count_ = 0;
  size_t too_big_count_ = 0;
};

}  // namespace sweepstake
