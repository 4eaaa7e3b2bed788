#include "engine_client/telemetry/resend_buffer.h"

#include <cassert>
#include <utility>

namespace sweepstake {

void ResendBuffer::Append(v1::StreamTelemetryRequest request) {
  request.set_sequence(next_sequence_++);
  entries_.push_back({.request = std::move(request)});
}

const ResendBuffer::Entry* ResendBuffer::Next() const {
  return cursor_ < entries_.size() ? &entries_[cursor_] : nullptr;
}

void ResendBuffer::MarkSent() {
  assert(cursor_ < entries_.size());
  entries_[cursor_].sent_before = true;
  ++cursor_;
}

void ResendBuffer::Acknowledge(uint64_t sequence) {
  if (sequence > last_sequence()) return;
  while (!entries_.empty() && entries_.front().request.sequence() <= sequence) {
    entries_.pop_front();
    if (cursor_ > 0) --cursor_;
  }
}

void ResendBuffer::Renumber() {
  next_sequence_ = 1;
  for (Entry& entry : entries_) entry.request.set_sequence(next_sequence_++);
}

uint64_t ResendBuffer::DiscardSent() {
  uint64_t frame_count = 0;
  for (; cursor_ > 0; --cursor_) {
    frame_count +=
        static_cast<uint64_t>(entries_.front().request.frame_batch().frame_time_ns_size());
    entries_.pop_front();
  }
  return frame_count;
}

const v1::FrameBatch* ResendBuffer::FirstBatch() const {
  for (const Entry& entry : entries_) {
    if (entry.request.has_frame_batch()) return &entry.request.frame_batch();
  }
  return nullptr;
}

}  // namespace sweepstake
