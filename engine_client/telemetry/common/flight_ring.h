// The flight recorder's memory of the latest frames. It keeps the measurements of all frames, and
// the boxes of some of them.
//
// The frame thread writes into the ring. A frame over the budget freezes the ring. From then on the
// sender thread owns it, until Release empties it and returns it to the frame thread. One atomic
// flag stores which thread owns it.
//
// The boxes of a frame are copied completely, because the ring cannot detect which boxes have
// moved. Between two copies enough time passes that the copies of five seconds fit into the memory.
// So in five seconds the frame thread copies at most the size of the memory, at 24 bytes per box.
// If a frame over the budget has no copied boxes, the ring copies the boxes of the next frame
// before it freezes.
//
// Time is the sum of the frame times passed by the game; no clock is read. Memory is allocated
// once. Cost: one load while the ring is frozen, otherwise the copy. It never waits, allocates or
// makes a system call.
#pragma once

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/aabb.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

// A frame in a frozen ring.
struct FlightFrame {
  FrameSample sample{};
  uint64_t first_box = 0;  // index of its first box since the ring was last emptied
  uint32_t box_count = 0;  // 0: its boxes were not copied, or were overwritten
};

class FlightRing {
 public:
  static constexpr uint64_t kSpanNs = 5'000'000'000;
  // Minimum frame time between two recordings (kCooldownNs) and before the first one (kWarmUpNs),
  // in ns. The first frames of a game are usually long, so they are not recorded.
  static constexpr uint64_t kCooldownNs = 30'000'000'000;
  static constexpr uint64_t kWarmUpNs = 1'000'000'000;
  // Maximum number of frames in the ring. Above about 800 frames/s they cover less than five
  // seconds. resize writes to the memory, so the frame thread will not cause page faults.
  static constexpr uint64_t kFrames = 4096;

  // Keeps at most `max_boxes` boxes. REQUIRES: max_boxes > 0, budget_ns > 0.
  FlightRing(size_t max_boxes, uint64_t budget_ns) : budget_ns_(budget_ns) {
    assert(max_boxes > 0 && budget_ns > 0);
    // Both calls write to the memory, so that the frame thread causes no page fault.
    boxes_.resize(max_boxes);
    frames_.resize(kFrames);
  }

  // Call these on the frame thread: OnBoxes with the frame's boxes, then OnFrame at the frame's
  // end.
  void OnBoxes(std::span<const Aabb> boxes) noexcept {
    if (!frozen() && IsDue(boxes.size())) Copy(boxes);
  }
  void OnFrame(const FrameSample& sample) noexcept;

  size_t max_boxes() const { return boxes_.size(); }
  // Returns the index of the latest frame. Any thread.
  uint64_t latest_frame_index() const {
    return latest_frame_index_.load(std::memory_order_relaxed);
  }
  // Returns whether the ring is frozen, which means that the sender thread owns it. Any thread.
  bool frozen() const { return frozen_.load(std::memory_order_acquire); }

  // The following functions run on the sender thread. REQUIRES: frozen().
  //
  // Returns the frames of the last five seconds, oldest first.
  std::vector<FlightFrame> Frames() const;
  // Returns box `index` of the frame. REQUIRES: index < frame.box_count.
  const Aabb& BoxOf(const FlightFrame& frame, uint32_t index) const {
    return boxes_[(frame.first_box + index) % boxes_.size()];
  }
  // Empties the ring and returns it to the frame thread.
  void Release();

 private:
  bool IsDue(size_t count) const;
  void Copy(std::span<const Aabb> boxes) noexcept;
  bool IsOverBudget(const FrameSample& sample) const {
    return sample.frame_time_ns > budget_ns_ && recorded_ns_ >= wait_ns_ &&
           (sample.flags & kFrameWithoutCost) == 0;
  }

  const uint64_t budget_ns_;
  std::atomic<bool> frozen_{false};
  std::atomic<uint64_t> latest_frame_index_{0};

  // Owned by the frame thread, or by the sender thread while the ring is frozen. "Began" means: was
  // last emptied.
  HookedVector<Aabb> boxes_;
  HookedVector<FlightFrame> frames_;
  uint64_t box_total_ = 0;        // boxes copied since the ring began
  uint64_t frame_total_ = 0;      // frames added since the ring began
  uint64_t recorded_ns_ = 0;      // frame time since the ring began
  uint64_t wait_ns_ = kWarmUpNs;  // no frame freezes the ring before recorded_ns_ reaches this
  uint64_t since_copy_ns_ = 0;    // frame time since the latest copy of boxes
  FlightFrame next_{};            // the current frame
  bool copied_any_ = false;
  bool awaits_boxes_ = false;  // the previous frame was over the budget and had no boxes
};

inline bool FlightRing::IsDue(size_t count) const {
  // A recording needs the boxes of at least two frames.
  if (count == 0 || count > boxes_.size() / 2 || next_.box_count != 0) return false;
  const uint64_t waited_ns = std::min(since_copy_ns_, kSpanNs);
  return !copied_any_ || awaits_boxes_ || waited_ns * boxes_.size() >= kSpanNs * count;
}

inline void FlightRing::Copy(std::span<const Aabb> boxes) noexcept {
  const size_t at = box_total_ % boxes_.size();
  const size_t first = std::min(boxes.size(), boxes_.size() - at);
  std::copy_n(boxes.begin(), first, boxes_.begin() + static_cast<ptrdiff_t>(at));
  std::copy(boxes.begin() + static_cast<ptrdiff_t>(first), boxes.end(), boxes_.begin());
  next_.first_box = box_total_;
  next_.box_count = static_cast<uint32_t>(boxes.size());
  box_total_ += boxes.size();
  since_copy_ns_ = 0;
  copied_any_ = true;
}

inline void FlightRing::OnFrame(const FrameSample& sample) noexcept {
  latest_frame_index_.store(sample.frame_index, std::memory_order_relaxed);
  if (frozen()) return;
  next_.sample = sample;
  frames_[frame_total_++ % kFrames] = next_;
  const bool has_boxes = next_.box_count != 0;
  next_ = {};
  recorded_ns_ += sample.frame_time_ns;
  since_copy_ns_ += sample.frame_time_ns;
  const bool was_awaiting = std::exchange(awaits_boxes_, false);
  if (was_awaiting || (IsOverBudget(sample) && has_boxes)) {
    frozen_.store(true, std::memory_order_release);
  } else {
    awaits_boxes_ = IsOverBudget(sample);
  }
}

inline std::vector<FlightFrame> FlightRing::Frames() const {
  assert(frozen());
  std::vector<FlightFrame> newest_first;
  uint64_t span_ns = 0;
  const uint64_t oldest = frame_total_ - std::min(frame_total_, kFrames);
  for (uint64_t index = frame_total_; index > oldest && span_ns < kSpanNs; --index) {
    FlightFrame frame = frames_[(index - 1) % kFrames];
    span_ns += frame.sample.frame_time_ns;
    if (box_total_ - frame.first_box > boxes_.size()) frame.box_count = 0;
    newest_first.push_back(frame);
  }
  return {newest_first.rbegin(), newest_first.rend()};
}

inline void FlightRing::Release() {
  assert(frozen());
  box_total_ = frame_total_ = recorded_ns_ = since_copy_ns_ = 0;
  copied_any_ = awaits_boxes_ = false;
  wait_ns_ = kCooldownNs;
  frozen_.store(false, std::memory_order_release);
}

}  // namespace sweepstake
