// The whole protocol of a session with a daemon, without network, clock or thread: bytes and the
// time come in, bytes go out. Whoever owns a gRPC stream of sweepstake.v1.TelemetryService, in
// whatever language, moves the bytes; what is in a message, when it is sent, sent again or given
// up, and when to connect, is decided here.
//
//   Connected → Advance, Take, OnMessage … → Disconnected → wait → Connected → …
//
// Advance is called every few milliseconds, connected or not: it empties the queue that the frame
// thread fills, and says what to do. At the end comes Goodbye, then Advance until finished().
//
// Time: ns on any monotonic clock, the same for all calls. Thread safety: one caller at a time; it
// is the queue's consumer. The frame thread never meets it: they share the queue and the mailboxes
// of AdaptiveBroadPhase. Memory: the messages that are not acknowledged, at most
// SessionOptions::unacknowledged_messages and a few more, whatever the daemon sends, one batch, and
// while an operator looks at boxes some 200 kB.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/telemetry/protocol/backoff.h"
#include "engine_client/telemetry/protocol/box_viewer.h"
#include "engine_client/telemetry/protocol/evidence_intake.h"
#include "engine_client/telemetry/protocol/messages.h"
#include "engine_client/telemetry/protocol/session_state.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// What the owner of the stream is to do.
enum class LinkAction : uint32_t {
  kNone = 0,    // nothing now
  kSend = 1,    // write the next message
  kFinish = 2,  // announce that there are no more messages, and read until the stream ends
  kCancel = 3,  // end the stream at once
};

// How a stream ended.
struct StreamEnd {
  uint32_t code = 0;        // of gRPC; 0: OK
  std::string message;      // of the status: any bytes, of which a line of at most 256 is told on
  std::string details;      // the bytes of grpc-status-details-bin; empty: none
  std::string advice = {};  // of the stream's owner, to follow the message; empty: none
};

// Of SessionLink: the stream that is being opened or is open.
struct LinkStream {
  uint64_t deadline_ns = 0;  // the daemon's next answer must come before it
  std::optional<uint64_t> online_since_ns;
  std::string mismatch;  // why there can be no session with this daemon; empty: there can be
  std::string fault;     // what the daemon did wrong; empty: nothing
  std::optional<uint32_t> reconnect_delay_ms;  // the daemon wants the client to come back after it
  bool hello_sent = false;
  bool goodbye_sent = false;
  bool finished = false;  // nothing more will be sent
  bool given_up = false;  // at the deadline of the goodbye

  // Nothing more is sent or taken, and the owner is told to cancel until it has.
  bool IsBeingCancelled() const { return given_up || !mismatch.empty() || !fault.empty(); }
};

class SessionLink {
 public:
  // `daemon` is what messages call the other side, as "the daemon at 127.0.0.1:7433". The same seed
  // gives the same delays; sessions of many games should have different ones. The queue and the
  // broad phase are borrowed. REQUIRES: options are valid (ValidateSessionOptions).
  SessionLink(const SessionOptions& options, std::string daemon, uint64_t jitter_seed,
              SampleQueue& queue, AdaptiveBroadPhase& adaptive);

  // Returns whether there is a stream: between Connected and Disconnected.
  bool connected() const { return stream_.has_value(); }
  // Notes that a stream was opened, or is being opened: the first message is for it. REQUIRES: the
  // former one, if any, was Disconnected, and the link is not finished.
  void Connected(uint64_t now_ns);
  // Empties the queue and returns what to do now. kSend and kFinish are done with Take, once the
  // stream can be written to; until then, Advance goes on to be called. kCancel is said again until
  // Disconnected.
  LinkAction Advance(uint64_t now_ns);
  // Returns the size in bytes of the next message, without taking it. REQUIRES: Advance returned
  // kSend, and nothing was called since.
  size_t next_message_bytes() const { return next_message_.size(); }
  // Returns the message to write; empty after kFinish. REQUIRES: Advance returned kSend or kFinish,
  // and nothing was called since.
  std::string Take(uint64_t now_ns);
  // Acts on a message of the daemon. kDataLoss: it cannot be read; nothing of the session is lost,
  // and Advance returns kCancel. kFailedPrecondition: there is no stream.
  Status OnMessage(std::string_view bytes, uint64_t now_ns);
  // Notes how the stream ended, after its last message, and returns how many ms to wait before the
  // next one; absent: there must be none, since the session has ended. Without Connected before it,
  // it says why no stream could be opened at all.
  std::optional<uint32_t> Disconnected(const StreamEnd& end, uint64_t now_ns);

  // Begins the end: what is in the queue is sent, then a goodbye, also if the game goes on. At the
  // deadline it is given up; without a stream it is at once, and what was not sent is lost. A later
  // call can only bring the deadline forward.
  void Goodbye(uint64_t deadline_ns);
  // Returns whether Goodbye was called and there is nothing more to do, but to end a stream that
  // was given up.
  bool finished() const { return goodbye_deadline_ns_ && (!stream_ || stream_->given_up); }

  // The frames that the queue dropped are not in it.
  SessionStats stats() const;

 private:
  std::string NextMessage();
  LinkAction NextStep(bool queue_empty, uint64_t now_ns);
  bool Overdue(uint64_t now_ns);
  void GiveUp();
  void OnWelcome(const protocol::Welcome& welcome, uint64_t now_ns);
  void OnAcknowledgement(const protocol::Acknowledgement& message);
  void OnCommand(const SwitchCommand& command, uint64_t now_ns);
  void OnOrder(const OperatorOrder& order);
  void Answer(std::string message);
  void TakeBeliefs(const std::vector<protocol::BetaPosterior>& posteriors);
  void TakeStandings(const std::vector<ArmStanding>& standings);
  void TakeVerdict(const SceneVerdict& verdict);
  bool Explain(const StreamEnd& end, const std::string& reason, const LinkStream& stream);
  uint32_t DelayMs(const StreamEnd& end, const std::string& reason, const LinkStream& stream,
                   uint64_t now_ns);

  const SessionOptions options_;
  const std::string daemon_;
  AdaptiveBroadPhase& adaptive_;
  SessionState state_;
  EvidenceIntake intake_;
  BoxViewer boxes_;
  Backoff backoff_;
  std::optional<LinkStream> stream_;
  LinkAction next_ = LinkAction::kNone;  // what Advance returned
  std::string next_message_;             // the one to send, if that is kSend
  bool next_is_view_ = false;            // that message is of boxes_
  std::optional<uint64_t> goodbye_deadline_ns_;
  bool taken_all_ = false;  // the queue was empty after Goodbye; later frames are not sent

  std::string last_error_;
  std::string refusal_;
  std::vector<ArmBelief> beliefs_;
  SceneVerdict verdict_;
  LastDecision last_decision_;
  uint64_t command_count_ = 0;
  uint64_t unknown_message_count_ = 0;
  protocol::Welcome welcome_;  // the latest one, with the batch interval of now
  bool takes_orders_ = false;  // from this daemon
  bool shows_boxes_ = false;   // to this daemon
};

}  // namespace sweepstake
