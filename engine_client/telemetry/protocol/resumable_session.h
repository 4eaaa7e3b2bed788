// The protocol of one session (telemetry.proto) without network, clock or threads. It holds the
// session's identity, the sequence numbers of its messages, the message to send next, and all state
// that survives a lost connection.
//
//   disconnected → Connect (Hello) → connecting → OnWelcome → online → Disconnect → …
//
// Resuming: the daemon's Welcome has the number of the latest message on disk. All later messages
// are sent again under the same numbers, in order.
//
// If Welcome does not resume the session, the daemon no longer has it, and a new session begins.
// The messages still in the buffer were never stored. They are renumbered from 1 and count for the
// new session.
//
// A daemon that refuses a Hello with NOT_FOUND or INVALID_ARGUMENT may do so because of its session
// id, so the next Hello has none. After INVALID_ARGUMENT it is unknown which messages are on disk.
// The messages sent so far are discarded then, because they could count twice in another session.
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
  // For a frame batch: the number of its frames, and the active arm and switch epoch of its first
  // frame. For other messages: 0.
  uint32_t frame_count = 0;
  uint32_t active_arm = 0;
  uint32_t switch_epoch = 0;
};

// The numbered messages that the daemon has not acknowledged. They are sent again on each new
// connection.
//
// Next returns the first message that was not yet sent on the current connection. Not thread-safe.
// Size: from `capacity` messages on, full() returns true and the caller must stop adding evidence.
// The few messages that are added after that are kept; the buffer never drops one by itself.
class ResendBuffer {
 public:
  struct Entry {
    EvidenceMessage evidence;
    uint64_t sequence = 0;
    bool sent_before = false;  // sent on any connection, not only the current one
  };

  // REQUIRES: capacity >= 1.
  explicit ResendBuffer(size_t capacity) : capacity_(capacity) {}

  // Adds the message under the next sequence number.
  void Append(EvidenceMessage evidence);
  bool full() const { return entries_.size() >= capacity_; }
  uint64_t last_sequence() const { return next_sequence_ - 1; }

  // Returns the first message not sent on the current connection; null if there is none.
  const Entry* Next() const;
  // Marks the message returned by Next as sent. REQUIRES: Next() != nullptr.
  void MarkSent();
  // Begins a new connection, on which all messages must be sent again.
  void Rewind() { cursor_ = 0; }

  // Removes the messages up to and including `sequence`, because the daemon has them on disk.
  // Ignores a number that was never assigned.
  void Acknowledge(uint64_t sequence);
  // Begins a new session: numbers the remaining messages from 1.
  void Renumber();
  // Drops the messages that were sent on any connection. Called if the daemon refused one of them,
  // or if it is unknown which of them it stored. Returns the number of dropped frames.
  uint64_t DiscardSent();

  // Returns the first frame batch; null if there is none.
  const EvidenceMessage* FirstBatch() const;

 private:
  const size_t capacity_;
  std::deque<Entry> entries_;  // sorted by sequence number
  size_t cursor_ = 0;          // index of the message that Next returns
  uint64_t next_sequence_ = 1;
};

class ResumableSession {
 public:
  // The arm, epoch and mode in which the next frame will be measured.
  struct Position {
    uint32_t active_arm = 0;
    uint32_t switch_epoch = 0;
    Mode mode = Mode::kAi;
  };

  // `hello` has the fields that do not change during the session: project, scene, arms and so on.
  ResumableSession(protocol::Hello hello, size_t unacknowledged_max);

  // Adds evidence. Call it in the order in which things happened, and not while full() returns
  // true.
  void Append(EvidenceMessage evidence) { buffer_.Append(std::move(evidence)); }
  bool full() const { return buffer_.full(); }

  // Begins a connection and returns its first message. `position` is the state of the game's next
  // frame. If a batch of frames is waiting to be sent, Hello describes that batch's first frame
  // instead.
  protocol::Hello Connect(const Position& position);
  void OnWelcome(const protocol::Welcome& welcome);
  // Removes acknowledged messages. Ignores a number that was not sent yet, so that no unsent
  // message is lost.
  void OnAcknowledgement(uint64_t sequence);
  bool online() const { return online_; }

  // Returns the next message to send; null if there is none, or if the session is not online.
  const ResendBuffer::Entry* Next() const { return online_ ? buffer_.Next() : nullptr; }
  // Marks the message returned by Next as sent. REQUIRES: Next() != nullptr.
  void MarkSent();

  // Records that the connection has ended. `unknown_session`: its status was NOT_FOUND. `refused`:
  // it was INVALID_ARGUMENT; the daemon would refuse Hello or a sent message again.
  void Disconnect(bool unknown_session, bool refused);
  // Ends the session's identity; the next connection begins a new session. Discards the sent
  // messages: the store may contain them under the old session, and they must not count twice.
  void ForgetSession();

  const std::string& session_id() const { return session_id_; }
  // The counts of connections, messages and frames; other members are not set. A frame that is sent
  // again counts once. A frame counts as dropped if DiscardSent dropped its message.
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
