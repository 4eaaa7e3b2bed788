// The protocol of a session with a daemon, without network, clock or thread. The caller owns a gRPC
// stream of sweepstake.v1.TelemetryService, in any language. It passes in the time and the received
// bytes, and sends the bytes that this class returns. This class decides what the messages contain,
// when they are sent, sent again or given up, and when to connect.
//
//   Connected → Advance, Take, OnMessage … → Disconnected → wait → Connected → …
//
// Call Advance every few milliseconds, connected or not. It empties the queue that the frame thread
// fills, and returns what to do. To end the session, call Goodbye, then Advance until finished().
//
// Time: ns on any monotonic clock, the same one for all calls. Thread safety: one caller at a time.
// The link must be the only consumer of the queue. It shares only the queue and the mailboxes of
// AdaptiveBroadPhase with the frame thread. Memory: the unacknowledged messages
// (SessionOptions::unacknowledged_messages and a few more), one batch, and about 200 kB while an
// operator views boxes.
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
#include "engine_client/telemetry/protocol/resumable_session.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// The next action of the stream's owner.
enum class LinkAction : uint32_t {
  kNone = 0,    // nothing now
  kSend = 1,    // write the next message
  kFinish = 2,  // announce that there are no more messages, and read until the stream ends
  kCancel = 3,  // end the stream at once
};

// How a stream ended.
struct StreamEnd {
  uint32_t code = 0;        // gRPC status code; 0: OK
  std::string message;      // the status message; any bytes. Errors show the first 256
  std::string details;      // bytes of grpc-status-details-bin; may be empty
  std::string advice = {};  // the stream owner's advice, shown after the message; may be empty
};

// State of SessionLink for a stream that is open or being opened.
struct LinkStream {
  uint64_t deadline_ns = 0;  // time by which the daemon must have answered
  std::optional<uint64_t> online_since_ns;
  std::string fault;  // the daemon's protocol error; empty if none
  // The delay before the next connection, as requested by the daemon.
  std::optional<uint32_t> reconnect_delay_ms;
  bool hello_sent = false;
  bool goodbye_sent = false;
  bool finished = false;  // nothing more will be sent
  bool given_up = false;  // the deadline of Goodbye has passed

  // Returns whether the stream is being cancelled. Nothing more is sent or accepted then, and
  // Advance returns kCancel until Disconnected is called.
  bool IsBeingCancelled() const { return given_up || !fault.empty(); }
};

class SessionLink {
 public:
  // `daemon` is used in error messages, such as "the daemon at 127.0.0.1:7433". `jitter_seed`
  // determines the random delays, so each session should have a different one. The queue and the
  // broad phase are borrowed. REQUIRES: options are valid (ValidateSessionOptions).
  SessionLink(const SessionOptions& options, std::string daemon, uint64_t jitter_seed,
              SampleQueue& queue, AdaptiveBroadPhase& adaptive);

  // Returns whether there is a stream: Connected was called, and Disconnected was not called since.
  bool connected() const { return stream_.has_value(); }
  // Records that a stream was opened or is being opened. The next message is the first one of this
  // stream. REQUIRES: Disconnected was called for the previous stream, if any, and finished() is
  // false.
  void Connected(uint64_t now_ns);
  // Empties the queue and returns what to do now. After kSend and kFinish, call Take as soon as the
  // stream is writable; until then, keep calling Advance. After kCancel, every call returns kCancel
  // until Disconnected.
  LinkAction Advance(uint64_t now_ns);
  // Returns the size in bytes of the message that Take will return. REQUIRES: Advance returned
  // kSend, and no other function was called since.
  size_t next_message_bytes() const { return next_message_.size(); }
  // Returns the message to write; empty after kFinish. REQUIRES: Advance returned kSend or kFinish,
  // and no other function was called since.
  std::string Take(uint64_t now_ns);
  // Processes a message of the daemon. kDataLoss: it cannot be parsed. The session keeps its
  // evidence, and Advance returns kCancel. kFailedPrecondition: there is no stream.
  Status OnMessage(std::string_view bytes, uint64_t now_ns);
  // Records how the stream ended; call it after the stream's last message. Returns the delay before
  // the next connection in ms, or nullopt if the session has ended. If no stream could be opened,
  // call it without Connected; `end` then has the reason.
  std::optional<uint32_t> Disconnected(const StreamEnd& end, uint64_t now_ns);

  // Starts to end the session: the content of the queue is sent, then a goodbye. Later frames are
  // not sent. The link gives up at the deadline, or at once if there is no stream; evidence that
  // was not sent is lost then. Another call can only make the deadline earlier.
  void Goodbye(uint64_t deadline_ns);
  // Returns whether Goodbye was called and nothing is left to send. If the stream was given up, its
  // owner must still close it.
  bool finished() const { return goodbye_deadline_ns_ && (!stream_ || stream_->given_up); }

  // Returns the statistics. dropped_frame_count does not include the frames that the queue dropped.
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
  void TakeBeliefs(const std::vector<decision::BetaPosterior>& posteriors);
  void TakeStandings(const std::vector<ArmStanding>& standings);
  void TakeVerdict(const SceneVerdict& verdict);
  void TakeSaving(std::optional<double> saved_us);
  bool Explain(const StreamEnd& end, const std::string& reason, const LinkStream& stream);
  uint32_t DelayMs(const StreamEnd& end, const std::string& reason, const LinkStream& stream,
                   uint64_t now_ns);

  const SessionOptions options_;
  const std::string daemon_;
  AdaptiveBroadPhase& adaptive_;
  ResumableSession state_;
  EvidenceIntake intake_;
  BoxViewer boxes_;
  Backoff backoff_;
  std::optional<LinkStream> stream_;
  LinkAction next_ = LinkAction::kNone;  // the latest result of Advance
  std::string next_message_;             // the message to send if next_ is kSend
  bool next_is_view_ = false;            // next_message_ comes from boxes_
  std::optional<uint64_t> goodbye_deadline_ns_;
  bool taken_all_ = false;  // Goodbye was called and the queue was empty after it

  std::string last_error_;
  std::string refusal_;
  std::vector<ArmBelief> beliefs_;
  SceneVerdict verdict_;
  std::optional<double> saved_us_;
  LastDecision last_decision_;
  uint64_t command_count_ = 0;
  uint64_t unknown_message_count_ = 0;
  protocol::Welcome welcome_;  // the latest welcome, with the current batch interval
  bool takes_orders_ = false;  // this daemon may send operator orders
  bool shows_boxes_ = false;   // this daemon may request boxes
};

}  // namespace sweepstake
