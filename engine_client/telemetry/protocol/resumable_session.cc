#include "engine_client/telemetry/protocol/resumable_session.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sweepstake {

void ResendBuffer::Append(EvidenceMessage evidence) {
  entries_.push_back({.evidence = std::move(evidence), .sequence = next_sequence_++});
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
  while (!entries_.empty() && entries_.front().sequence <= sequence) {
    entries_.pop_front();
    if (cursor_ > 0) --cursor_;
  }
}

void ResendBuffer::Renumber() {
  next_sequence_ = 1;
  for (Entry& entry : entries_) entry.sequence = next_sequence_++;
}

uint64_t ResendBuffer::DiscardSent() {
  uint64_t frame_count = 0;
  while (!entries_.empty() && entries_.front().sent_before) {
    frame_count += entries_.front().evidence.frame_count;
    entries_.pop_front();
  }
  cursor_ = 0;
  return frame_count;
}

const EvidenceMessage* ResendBuffer::FirstBatch() const {
  const auto first = std::find_if(entries_.begin(), entries_.end(), [](const Entry& entry) {
    return entry.evidence.frame_count > 0;
  });
  return first == entries_.end() ? nullptr : &first->evidence;
}

ResumableSession::ResumableSession(protocol::Hello hello, size_t unacknowledged_max)
    : hello_(std::move(hello)), buffer_(unacknowledged_max) {}

protocol::Hello ResumableSession::Connect(const Position& position) {
  online_ = false;
  protocol::Hello hello = hello_;
  hello.session_id = session_id_;
  hello.resume_token = resume_token_;
  hello.mode = position.mode;
  const EvidenceMessage* batch = buffer_.FirstBatch();
  hello.active_arm = batch != nullptr ? batch->active_arm : position.active_arm;
  hello.switch_epoch = batch != nullptr ? batch->switch_epoch : position.switch_epoch;
  return hello;
}

void ResumableSession::OnWelcome(const protocol::Welcome& welcome) {
  const bool resumed = welcome.resumed && welcome.session_id == session_id_;
  // The daemon could not read its store. The store may already contain the sent messages under the
  // old session's id. So drop them, to prevent that they count again in the new session.
  if (!resumed && welcome.priors_unavailable && !session_id_.empty())
    counts_.dropped_frame_count += buffer_.DiscardSent();
  if (!resumed) BeginSession();
  session_id_ = welcome.session_id;
  resume_token_ = welcome.resume_token;
  online_ = true;
  buffer_.Rewind();
  ++counts_.connection_count;
  if (!resumed) return;
  ++counts_.resumed_count;
  OnAcknowledgement(welcome.acknowledged_sequence);
}

void ResumableSession::BeginSession() {
  buffer_.Renumber();
  counts_.acknowledged_sequence = 0;
  counts_.sent_sequence = 0;
}

void ResumableSession::OnAcknowledgement(uint64_t sequence) {
  if (sequence > counts_.sent_sequence) return;
  buffer_.Acknowledge(sequence);
  counts_.acknowledged_sequence = std::max(counts_.acknowledged_sequence, sequence);
}

void ResumableSession::MarkSent() {
  const ResendBuffer::Entry& entry = *buffer_.Next();
  if (entry.sent_before) {
    ++counts_.resent_message_count;
  } else {
    counts_.sent_frame_count += entry.evidence.frame_count;
  }
  counts_.sent_sequence = std::max(counts_.sent_sequence, entry.sequence);
  buffer_.MarkSent();
}

void ResumableSession::Disconnect(bool unknown_session, bool refused) {
  if (refused && online_) counts_.dropped_frame_count += buffer_.DiscardSent();
  if (refused && !online_) ForgetSession();
  if (unknown_session) session_id_.clear();
  online_ = false;
}

void ResumableSession::ForgetSession() {
  counts_.dropped_frame_count += buffer_.DiscardSent();
  session_id_.clear();
}

}  // namespace sweepstake
