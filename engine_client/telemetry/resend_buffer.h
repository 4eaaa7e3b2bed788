// Numbered messages that the daemon has not acknowledged, so that a new connection can send them
// again.
//
// A cursor runs over the messages of this connection: Next is the first one not sent on it yet. Not
// thread-safe. Bound: full() at `capacity` messages; the caller then stops adding (a few more are
// taken, none is ever dropped here).
#pragma once

#include <cstdint>
#include <deque>

#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

class ResendBuffer {
 public:
  struct Entry {
    v1::StreamTelemetryRequest request;  // with its sequence number
    bool sent_before = false;            // on any connection
  };

  // REQUIRES: capacity >= 1.
  explicit ResendBuffer(size_t capacity) : capacity_(capacity) {}

  // Gives the message the next sequence number.
  void Append(v1::StreamTelemetryRequest request);
  bool full() const { return entries_.size() >= capacity_; }
  size_t size() const { return entries_.size(); }
  uint64_t last_sequence() const { return next_sequence_ - 1; }

  // The first message not sent on this connection; null: none.
  const Entry* Next() const;
  // The message of Next is on its way. REQUIRES: Next() != nullptr.
  void MarkSent();
  // A new connection: everything is to be sent again.
  void Rewind() { cursor_ = 0; }

  // Messages up to `sequence` are on disk. A number that was never given is ignored.
  void Acknowledge(uint64_t sequence);
  // A new session: what is left gets numbers from 1 on.
  void Renumber();
  // The daemon refused one of the messages sent on this connection: drops them. Returns the frames
  // they held.
  uint64_t DiscardSent();

  // The first frame batch; null: none.
  const v1::FrameBatch* FirstBatch() const;

 private:
  const size_t capacity_;
  std::deque<Entry> entries_;  // in the order of their numbers
  size_t cursor_ = 0;          // index of Next
  uint64_t next_sequence_ = 1;
};

}  // namespace sweepstake
