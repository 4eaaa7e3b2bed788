#include "engine_client/telemetry/session_state.h"

#include <algorithm>
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
  while (!entries_.empty() && entries_.front().sent_before) {
    frame_count +=
        static_cast<uint64_t>(entries_.front().request.frame_batch().frame_time_ns_size());
    entries_.pop_front();
  }
  cursor_ = 0;
  return frame_count;
}

const v1::FrameBatch* ResendBuffer::FirstBatch() const {
  for (const Entry& entry : entries_) {
    if (entry.request.has_frame_batch()) return &entry.request.frame_batch();
  }
  return nullptr;
}

SessionState::SessionState(v1::Hello hello, size_t unacknowledged_max)
    : hello_(std::move(hello)), buffer_(unacknowledged_max) {}

v1::StreamTelemetryRequest SessionState::Connect(const Position& position) {
  online_ = false;
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello = hello_;
  hello.set_session_id(session_id_);
  hello.set_resume_token(resume_token_);
  hello.set_mode(position.mode);
  hello.set_active_arm(position.active_arm);
  hello.set_switch_epoch(position.switch_epoch);
  if (const v1::FrameBatch* batch = buffer_.FirstBatch()) {
    hello.set_active_arm(batch->arm(0));
    hello.set_switch_epoch(batch->switch_epoch(0));
  }
  return request;
}

void SessionState::OnWelcome(const v1::Welcome& welcome) {
  const bool resumed = welcome.resumed() && welcome.session_id() == session_id_;
  // The store may have what was sent to a session that it could not read: a new session must not
  // have it again.
  if (!resumed && welcome.priors_unavailable() && !session_id_.empty())
    counts_.discarded_frame_count += buffer_.DiscardSent();
  if (!resumed) BeginSession();
  session_id_ = welcome.session_id();
  resume_token_ = welcome.resume_token();
  online_ = true;
  buffer_.Rewind();
  ++counts_.connection_count;
  if (!resumed) return;
  ++counts_.resumed_count;
  OnAcknowledgement(welcome.acknowledged_sequence());
}

void SessionState::BeginSession() {
  buffer_.Renumber();
  counts_.acknowledged_sequence = 0;
  counts_.sent_sequence = 0;
}

void SessionState::OnAcknowledgement(uint64_t sequence) {
  if (sequence > buffer_.last_sequence()) return;
  buffer_.Acknowledge(sequence);
  counts_.acknowledged_sequence = std::max(counts_.acknowledged_sequence, sequence);
}

const v1::StreamTelemetryRequest* SessionState::Next() const {
  if (!online_) return nullptr;
  const ResendBuffer::Entry* entry = buffer_.Next();
  return entry == nullptr ? nullptr : &entry->request;
}

void SessionState::MarkSent() {
  const ResendBuffer::Entry& entry = *buffer_.Next();
  if (entry.sent_before) {
    ++counts_.resent_message_count;
  } else {
    counts_.sent_frame_count +=
        static_cast<uint64_t>(entry.request.frame_batch().frame_time_ns_size());
  }
  counts_.sent_sequence = std::max(counts_.sent_sequence, entry.request.sequence());
  buffer_.MarkSent();
}

void SessionState::Disconnect(bool unknown_session, bool refused) {
  if (refused && online_) counts_.discarded_frame_count += buffer_.DiscardSent();
  if (refused && !online_) ForgetSession();
  if (unknown_session) session_id_.clear();
  online_ = false;
}

void SessionState::ForgetSession() {
  counts_.discarded_frame_count += buffer_.DiscardSent();
  session_id_.clear();
}

}  // namespace sweepstake
