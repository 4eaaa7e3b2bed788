// The rules of a telemetry stream, independent of the transport: the order of messages, the
// session, the responses, and the end. Used on the decision loop only.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/auth/rate_limit.h"
#include "server/rpc/services/service_context.h"
#include "server/sessions/game_session.h"
#include "server/sessions/session_opening.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

class TelemetryStream;

// All open telemetry streams of the daemon.
struct TelemetryStreams {
  std::map<uint64_t, TelemetryStream*> all;  // by number, the oldest first
  // Number of streams per address of another machine.
  std::map<std::string, uint32_t> address_counts;
  uint64_t last_number = 0;
  bool draining = false;
  int64_t next_store_warning_ns = std::numeric_limits<int64_t>::min();
  int64_t next_unknown_arms_note_ns = std::numeric_limits<int64_t>::min();
  int64_t next_suspension_note_ns = std::numeric_limits<int64_t>::min();
  int64_t next_invalid_boxes_note_ns = std::numeric_limits<int64_t>::min();

  // Refuses new streams and requests the connected clients to reconnect later.
  void Drain(const RpcOptions& options);
  // Ends the streams of callers whose tokens are no longer valid.
  void EndRefused();
};

// Returns the delay after which a drained client should reconnect. `rank` numbers the drained
// clients from 0.
uint32_t ReconnectDelayMs(const RpcOptions& options, uint64_t rank);

// Returns how long (ms) a client collects frames before it sends them as a batch: an eighth of the
// decision interval, 250 ms at most. If there are many streams, it is longer, up to half of the
// decision interval, so that all streams together send at most 10,000 batches per second.
uint32_t BatchIntervalMs(uint32_t decision_interval_ms, uint64_t stream_count);

// The transport of a stream. It owns the stream and calls its functions OnMessage, OnWritten and so
// on. The stream calls the functions below on the decision loop. They do not block, and do not call
// the stream.
class TelemetryTransport {
 public:
  virtual ~TelemetryTransport() = default;

  static constexpr size_t kMaxReads = 2;

  // Requests one message. Each call leads to one OnMessage. When the client half-closes the stream,
  // all pending calls together lead to one OnHalfClose, and no message follows. At most kMaxReads
  // calls are pending. While the stream uses a request, at most one is pending. The stream calls
  // Read again when it is done with the request.
  virtual void Read() = 0;
  // Each call leads to one OnWritten. At most one write is pending.
  virtual void Write(const v1::StreamTelemetryResponse& response) = 0;
  // Ends the stream. Called exactly once, while no write is pending.
  virtual void Finish(const absl::Status& status) = 0;
  // Makes a pending write fail, even if the client does not read.
  virtual void Cancel(const absl::Status& status) = 0;
  // The client's address, for the log.
  virtual std::string peer() const = 0;
};

// One connection of one session: passes messages to the session, and sends the session's responses.
//
// While the session applies one message, the next message is read, so that a bail-out arrives
// together with the batch before it. No further messages are read, so that a flood of messages
// waits in the client's buffers. At most one write is pending, and the outbox is bounded.
// TelemetryTransport::Finish is called exactly once, whatever ends the stream.
class TelemetryStream final : public sessions::ClientStream,
                              public std::enable_shared_from_this<TelemetryStream> {
 public:
  TelemetryStream(ServiceContext& context, TelemetryStreams& streams, TelemetryTransport& transport,
                  auth::Principal caller)
      : context_(context), streams_(streams), transport_(transport), caller_(std::move(caller)) {}

  // Called first: counts the stream, and starts to read the Hello.
  void Accept();
  // Applies the message that was read; `request` is null if it does not parse. The stream may move
  // content out of `request`.
  void OnMessage(v1::StreamTelemetryRequest* request);
  // Called when the client has half-closed the stream.
  void OnHalfClose();
  // Called when a write has ended. `ok` is true if it succeeded.
  void OnWritten(bool ok);
  // Called when the connection is lost. Pending reads and writes fail.
  void OnCancelled();
  // Called last, when no read or write is pending any more.
  void OnDone();

  // Ends the stream if the caller's token was revoked or has expired.
  void EndIfRefused();
  // Requests the client to reconnect after `delay_ms`, because the daemon is shutting down, and
  // ends the stream once its evidence is on disk.
  void Drain(uint32_t delay_ms);

  void SendSwitch(const SwitchCommand& command) override;
  void SendAcknowledgement(uint64_t sequence) override;
  void PutSnapshot(const decision::DecisionRecord& record) override;
  void Flush() override { WriteNext(); }
  void SendReconnect(uint32_t delay_ms) override;
  void SendOrder(uint64_t order_id, const decision::OrderReport& order) override;
  void SendBoxRequest(uint32_t interval_ms, uint32_t max_bytes, uint32_t until_ms) override;
  bool SpendBailOut() override;
  void Close(const absl::Status& status) override;
  void Abort(const absl::Status& status) override;

 private:
  // Counts the stream for its address. Error: RESOURCE_EXHAUSTED (the address has
  // RpcOptions::max_streams_per_address streams).
  absl::Status CountAddress();
  // Counts a message against the rate limits. Error: RESOURCE_EXHAUSTED (the stream exceeds
  // RpcOptions::max_messages_per_s, or its party exceeds max_hellos_per_s).
  absl::Status CountMessage(const v1::StreamTelemetryRequest& request);
  absl::Status Dispatch(v1::StreamTelemetryRequest& request);
  absl::Status Open(v1::Hello& hello);
  void OnOpened(const absl::StatusOr<sessions::OpenedSession>& opened);
  // Returns whether the time `next_ns` of the next note in the log has come, and sets it one minute
  // later.
  bool NoteIsDue(int64_t& next_ns) const;
  // Counts a session that begins without some of its stored evidence, because the store could not
  // read it. Logs a warning at most once per minute for all streams.
  void ReportMissingEvidence(const absl::Status& status);
  // Counts a session whose evidence about some arms is not stored, because a player must not add
  // arms. Logs a warning at most once per minute for all streams.
  void ReportUnknownArms(const sessions::SessionIdentity& identity);
  void Enter(const sessions::OpenedSession& opened);
  // Logs that the session's game was suspended, at most once per minute for all streams.
  void ReportSuspension(const sessions::GameSession& session);
  // Logs that `count` objects have invalid boxes, at most once per minute for all streams.
  void ReportInvalidBoxes(const sessions::GameSession& session, uint32_t count);
  void Reject(const absl::Status& status);
  // Returns the message that the next write sends, so that the caller can set its fields.
  v1::StreamTelemetryResponse& Outbox();
  v1::StreamTelemetryResponse TakeOutbox();
  void ClearOutbox();
  void WriteNext();
  void LeaveSession();
  // Returns whether the client has ended the session with a Goodbye. Messages after it are ignored.
  // Evidence from messages before it is still stored.
  bool SaidGoodbye() const;

  ServiceContext& context_;
  TelemetryStreams& streams_;
  TelemetryTransport& transport_;
  const auth::Principal caller_;
  uint64_t number_ = 0;  // key of this stream in streams_
  std::string address_;  // streams_ counts it under this address; empty: not counted
  std::shared_ptr<sessions::GameSession> session_;
  std::shared_ptr<sessions::SessionOpening> opening_;  // from Hello until the session exists
  sessions::Telemetry telemetry_;                      // a buffer that is reused for each message
  double time_scale_ = 1;                              // from the Hello
  uint32_t decision_interval_ms_ = 0;
  uint32_t batch_interval_ms_ = 0;  // the latest value that was sent to the client
  auth::RateBucket messages_;
  // The next message. It contains only the latest value of each field, so that a slow
  // client receives the newest state and costs the memory of one response.
  v1::StreamTelemetryResponse outbox_;
  bool has_outbox_ = false;
  bool writing_ = false;
  std::optional<absl::Status>
      end_;  // the status with which the stream ends, once the outbox is empty
  bool finished_ = false;
};

}  // namespace sweepstake::rpc
