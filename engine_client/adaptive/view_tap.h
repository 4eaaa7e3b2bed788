// Copies some of a frame's boxes from the frame thread to another thread, so that an operator can
// view them.
//
// The other thread requests boxes. The frame thread then copies every stride-th box of the next
// frame. Without a request it copies nothing. Memory: 24 bytes per requested box, until Release.
//
// Thread safety: OnFrame on the frame thread, the other functions on the requesting thread. Cost of
// OnFrame: one load, and the copy if boxes are requested. It never waits, allocates or makes a
// system call.
#pragma once

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

struct ViewedFrame {
  uint64_t frame_index = 0;
  size_t object_count = 0;
  size_t stride = 1;
  std::span<const Aabb> boxes;  // objects 0, stride, 2 · stride …; valid until the next Request
};

class ViewTap {
 public:
  void OnFrame(std::span<const Aabb> boxes, uint64_t frame_index) noexcept {
    if (state_.load(std::memory_order_relaxed) == State::kWanted) Copy(boxes, frame_index);
  }

  // Requests at most `max_boxes` boxes of the next frame. REQUIRES: max_boxes > 0, and no other
  // request is pending.
  void Request(size_t max_boxes);
  // Returns whether the requested boxes were copied.
  bool has_frame() const { return state_.load(std::memory_order_acquire) == State::kThere; }
  // REQUIRES: has_frame().
  ViewedFrame frame() const;
  // Cancels a pending request and frees the memory. Returns false and does nothing while the frame
  // thread is copying.
  bool Release();

 private:
  enum class State : uint32_t { kIdle, kWanted, kCopying, kThere };

  void Copy(std::span<const Aabb> boxes, uint64_t frame_index) noexcept;

  std::atomic<State> state_{State::kIdle};
  // Owned by the frame thread while it copies, otherwise by the requesting thread.
  HookedVector<Aabb> storage_;
  ViewedFrame frame_;
};

inline void ViewTap::Copy(std::span<const Aabb> boxes, uint64_t frame_index) noexcept {
  State wanted = State::kWanted;
  if (!state_.compare_exchange_strong(wanted, State::kCopying, std::memory_order_acquire)) return;
  const size_t stride = std::max<size_t>(1, (boxes.size() + storage_.size() - 1) / storage_.size());
  size_t count = 0;
  for (size_t object = 0; object < boxes.size(); object += stride)
    storage_[count++] = boxes[object];
  frame_ = {.frame_index = frame_index,
            .object_count = boxes.size(),
            .stride = stride,
            .boxes = std::span<const Aabb>(storage_).first(count)};
  state_.store(State::kThere, std::memory_order_release);
}

inline void ViewTap::Request(size_t max_boxes) {
  assert(max_boxes > 0);
  // resize writes to the memory, so the frame thread will not cause page faults.
  if (storage_.size() != max_boxes) storage_.resize(max_boxes);
  state_.store(State::kWanted, std::memory_order_release);
}

inline ViewedFrame ViewTap::frame() const {
  assert(has_frame());
  return frame_;
}

inline bool ViewTap::Release() {
  State wanted = State::kWanted;
  state_.compare_exchange_strong(wanted, State::kIdle, std::memory_order_acquire);
  if (state_.load(std::memory_order_acquire) == State::kCopying) return false;
  state_.store(State::kIdle, std::memory_order_relaxed);
  frame_ = {};
  HookedVector<Aabb>().swap(storage_);
  return true;
}

}  // namespace sweepstake
