// The protocol of one session (telemetry.proto) without network, clock or threads: the session's
// identity, the numbers of its messages, the message to send next, and the state that survives a
// lost connection.
//
//   disconnected → Connect (Hello) → connecting → OnWelcome → online → Disconnect → …
//
// Resuming: the daemon's welcome states which messages are on disk. All later messages are sent
// again under the same numbers, in order. If the welcome does not resume the session, the daemon
// does not know it any more, and a new session begins. The remaining messages were never stored, so
// they are renumbered from 1 and count for the new session. A Hello that is refused with NOT_FOUND
// or INVALID_ARGUMENT may have been refused because of its session id, so the next Hello has none.
// After INVALID_ARGUMENT it is unknown which messages are on disk. The sent messages are then
// discarded, because they could count twice in another session.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "engine_client/telemetry/protocol/messages.h"
#include "sweepstake/session.h"

namespace sweepstake {

// A message with evidence, encoded without its sequence number (wire.h).
struct EvidenceMessage {
  std::string message;
  // For a frame batch: its frame count, and the state in which its first frame was measured.
  // Otherwise 0.
  uint32_t frame_count = 0;
  uint32_t active_arm = 0;
  uint32_t switch_epoch = 0;
};

// The numbered messages that the daemon has not acknowledged. A new connection sends them again.
//
// Next returns the first message that was not yet sent on the current connection. Not thread-safe.
// Bound: full() returns true from `capacity` messages on; the caller must then stop adding
// evidence. The buffer accepts the few messages added after that, and never drops one.
class ResendBuffer {
 public:
  struct Entry {
    EvidenceMessage evidence;
    uint64_t sequence = 0;
    bool sent_before = false;  // whether any connection has sent it
  };

  // REQUIRES: capacity >= 1.
  explicit ResendBuffer(size_t capacity) : capacity_(capacity) {}

  // Adds the message under the next sequence number.
  void Append(EvidenceMessage evidence);
  bool full() const { return entries_.size() >= capacity_; }
  uint64_t last_sequence() const { return next_sequence_ - 1; }

  // Returns the first message not sent on this connection; null if there is none.
  const Entry* Next() const;
  // Advances Next by one message, after it was sent. REQUIRES: Next() != nullptr.
  void MarkSent();
  // Begins a new connection: all messages must be sent again.
  void Rewind() { cursor_ = 0; }

  // Removes the messages up to `sequence`, which the daemon has on disk. A number that was never
  // assigned is ignored.
  void Acknowledge(uint64_t sequence);
  // Begins a new session: the remaining messages get numbers from 1 on.
  void Renumber();
  // Drops the messages that any connection has sent, because the daemon refused one of them or does
  // not know which of them it stored. Returns the number of dropped frames.
  uint64_t DiscardSent();

  // Returns the first frame batch; null if there is none.
  const EvidenceMessage* FirstBatch() const;

 private:
  const size_t capacity_;
  std::deque<Entry> entries_;  // sorted by sequence number
  size_t cursor_ = 0;          // index of Next
  uint64_t next_sequence_ = 1;
};

class ResumableSession {
 public:
  // The state in which the session's next frame will be measured.
  struct Position {
    uint32_t active_arm = 0;
    uint32_t switch_epoch = 0;
    Mode mode = Mode::kAi;
  };

  // `hello` has the fields that do not change: project, scene, arms and so on.
  ResumableSession(protocol::Hello hello, size_t unacknowledged_max);

  // Adds evidence, in the order in which it happened. The caller must not add evidence while full()
  // returns true.
  void Append(EvidenceMessage evidence) { buffer_.Append(std::move(evidence)); }
  bool full() const { return buffer_.full(); }

  // Begins a connection and returns its first message. `position` describes the next frame of the
  // game. If frames are waiting to be sent, Hello describes the oldest of them instead.
  protocol::Hello Connect(const Position& position);
  void OnWelcome(const protocol::Welcome& welcome);
  // Ignores a number that no connection has sent yet, so that no unsent message is dropped.
  void OnAcknowledgement(uint64_t sequence);
  bool online() const { return online_; }

  // Returns the next message to send; null if there is none or the session is not online.
  const ResendBuffer::Entry* Next() const { return online_ ? buffer_.Next() : nullptr; }
  // Advances Next by one message, after it was sent. REQUIRES: Next() != nullptr.
  void MarkSent();

  // Notes that the connection has ended. `unknown_session`: with NOT_FOUND. `refused`: with
  // INVALID_ARGUMENT, so a message sent on it, or its Hello, would be refused again.
  void Disconnect(bool unknown_session, bool refused);
  // Gives up the session. Discards the sent messages: the store may contain them under this
  // session, so they would count twice in another one.
  void ForgetSession();

  const std::string& session_id() const { return session_id_; }
  // The counts of connections, messages and frames; the other members are not set. A frame that was
  // sent again is counted once, and a dropped one was in a message that DiscardSent dropped.
  const SessionStats& counts() const { return counts_; }

 private:
  void BeginSession();

  const protocol::Hello hello_;
  ResendBuffer buffer_;
  std::string session_id_;    // empty: none yet
  std::string resume_token_;  // secret that belongs to session_id_
  bool online_ = false;
  SessionStats counts_;
};

}  // namespace sweepstake
