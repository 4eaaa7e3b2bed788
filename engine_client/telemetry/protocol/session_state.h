// The protocol of one session (telemetry.proto) without network, clock or threads: the session's
// identity, the numbers of its messages, the message to send next, and the state that survives a
// lost connection.
//
//   disconnected → Connect (Hello) → connecting → OnWelcome → online → Disconnect → …
//
// Resuming: the daemon's welcome says which messages are on disk. Everything later is sent again
// under the same numbers, in order. When the daemon no longer knows the session (a welcome that
// does not resume), a new session begins: the remaining messages were never durable, so they get
// new numbers from 1 and count for the new session. A Hello that is refused with NOT_FOUND or
// INVALID_ARGUMENT may have been refused for its session, so the next one does not name it. With
// INVALID_ARGUMENT the daemon has not said what of the session is on disk: what was sent is
// discarded, since it could count twice in another session.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "engine_client/telemetry/protocol/messages.h"

namespace sweepstake {

// A message with evidence, encoded (wire.h) but for its number.
struct EvidenceMessage {
  std::string message;
  // Of a batch, its frames and the state that its first frame was observed in.
  uint32_t frame_count = 0;
  uint32_t active_arm = 0;
  uint32_t switch_epoch = 0;
};

// Numbered messages that the daemon has not acknowledged, so that a new connection can send them
// again.
//
// A cursor runs over the messages of this connection: Next is the first one that was not sent on it
// yet. Not thread-safe. Bound: full() at `capacity` messages; the caller then stops adding. A few
// more are taken; none is ever dropped here.
class ResendBuffer {
 public:
  struct Entry {
    EvidenceMessage evidence;
    uint64_t sequence = 0;
    bool sent_before = false;  // true if any connection has sent it
  };

  // REQUIRES: capacity >= 1.
  explicit ResendBuffer(size_t capacity) : capacity_(capacity) {}

  // Gives the message the next sequence number.
  void Append(EvidenceMessage evidence);
  bool full() const { return entries_.size() >= capacity_; }
  uint64_t last_sequence() const { return next_sequence_ - 1; }

  // Returns the first message not sent on this connection; null if there is none.
  const Entry* Next() const;
  // Moves on after the message of Next was sent. REQUIRES: Next() != nullptr.
  void MarkSent();
  // Begins a new connection: everything is to be sent again.
  void Rewind() { cursor_ = 0; }

  // Removes the messages up to `sequence`, which are on disk. A number that was never assigned is
  // ignored.
  void Acknowledge(uint64_t sequence);
  // Begins a new session: the remaining messages get numbers from 1 on.
  void Renumber();
  // Drops the messages that any connection has sent, since the daemon refused one of them or cannot
  // tell which it has. Returns the number of frames they held.
  uint64_t DiscardSent();

  // Returns the first frame batch; null if there is none.
  const EvidenceMessage* FirstBatch() const;

 private:
  const size_t capacity_;
  std::deque<Entry> entries_;  // sorted by sequence number
  size_t cursor_ = 0;          // index of Next
  uint64_t next_sequence_ = 1;
};

class SessionState {
 public:
  // The state that the session's next frame will be observed in.
  struct Position {
    uint32_t active_arm = 0;
    uint32_t switch_epoch = 0;
    Mode mode = Mode::kAi;
  };

  struct Counts {
    uint64_t connection_count = 0;
    uint64_t resumed_count = 0;
    uint64_t resent_message_count = 0;
    uint64_t sent_frame_count = 0;       // counts a frame once, however often it was sent
    uint64_t discarded_frame_count = 0;  // refused by the daemon
    uint64_t acknowledged_sequence = 0;
    uint64_t sent_sequence = 0;
  };

  // `hello` holds what does not change: project, scene, arms and so on.
  SessionState(protocol::Hello hello, size_t unacknowledged_max);

  // Adds evidence, in the order it happened. It is never dropped here: the caller stops adding
  // while full().
  void Append(EvidenceMessage evidence) { buffer_.Append(std::move(evidence)); }
  bool full() const { return buffer_.full(); }

  // Begins a connection and returns its first message. `position` describes the frames that were
  // not sent yet; where frames will be sent again, the oldest of them takes its place.
  protocol::Hello Connect(const Position& position);
  void OnWelcome(const protocol::Welcome& welcome);
  // A number that was not sent yet, on any connection, is ignored: nothing is dropped unsent.
  void OnAcknowledgement(uint64_t sequence);
  bool online() const { return online_; }

  // Returns the next evidence to write; null if there is none or the session is not online.
  const ResendBuffer::Entry* Next() const { return online_ ? buffer_.Next() : nullptr; }
  // Moves on after the message of Next was sent. REQUIRES: Next() != nullptr.
  void MarkSent();

  // Notes that the connection has ended: with NOT_FOUND if `unknown_session`; with INVALID_ARGUMENT
  // if `refused`, so that one of the messages sent on it, or its Hello, would be refused forever.
  void Disconnect(bool unknown_session, bool refused);
  // Gives the session up. What was sent may be in the store under it, and would count twice in
  // another one, so it is discarded.
  void ForgetSession();

  const std::string& session_id() const { return session_id_; }
  const Counts& counts() const { return counts_; }

 private:
  void BeginSession();

  const protocol::Hello hello_;
  ResendBuffer buffer_;
  std::string session_id_;    // empty: none yet
  std::string resume_token_;  // secret; of session_id_
  bool online_ = false;
  Counts counts_;
};

}  // namespace sweepstake
