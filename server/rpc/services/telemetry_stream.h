// The rules of a telemetry stream, whatever it is carried by: what may come when, which session it
// has, what it sends, and how it ends. Used on the decision loop only.
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

// All streams.
struct TelemetryStreams {
  std::map<uint64_t, TelemetryStream*> all;        // in the order of their coming
  std::map<std::string, uint32_t> address_counts;  // of the streams from other machines
  uint64_t last_number = 0;
  bool draining = false;
  int64_t next_store_warning_ns = std::numeric_limits<int64_t>::min();

  // Refuses new streams and tells the others to reconnect later.
  void Drain(const RpcOptions& options);
  // Ends those of callers whose tokens are not valid any more.
  void EndRefused();
};

// Returns the delay after which a drained client is to come back. Ranks are those of all clients,
// from 0.
uint32_t ReconnectDelayMs(const RpcOptions& options, uint64_t rank);

// Returns how long a client collects frames: an eighth of the decision interval, 250 ms at most.
// With more streams it is longer, so that all together send 10,000 batches a second, but at most
// half of the decision interval.
uint32_t BatchIntervalMs(uint32_t decision_interval_ms, uint64_t stream_count);

// What carries a stream. It owns the stream and tells it what happens; its functions are called on
// the decision loop, do not wait and do not call the stream back.
class TelemetryTransport {
 public:
  virtual ~TelemetryTransport() = default;

  static constexpr size_t kMaxReads = 2;

  // Leads to one OnMessage, or with the others that are pending to OnHalfClose, behind which
  // nothing comes. At most kMaxReads are pending, or one while OnMessage uses a request: it asks
  // for more when it needs that no longer.
  virtual void Read() = 0;
  // Leads to one OnWritten. At most one write is pending.
  virtual void Write(const v1::StreamTelemetryResponse& response) = 0;
  // Ends the stream. Called exactly once, while no write is pending.
  virtual void Finish(const absl::Status& status) = 0;
  // Makes a pending write fail that waits for a client that does not read.
  virtual void Cancel(const absl::Status& status) = 0;
  // The client's address, for the log.
  virtual std::string peer() const = 0;
};

// One connection of one session: it passes messages to the session, and sends the session's.
//
// While the session applies one message the next is read, so that a bail-out is there with the
// batch before it; no more are, so that a flood waits in the client's own buffers. At most one
// write is pending, and the outbox behind it is bounded. Finish is called exactly once, whatever
// ends the stream.
class TelemetryStream final : public sessions::ClientStream,
                              public std::enable_shared_from_this<TelemetryStream> {
 public:
  TelemetryStream(ServiceContext& context, TelemetryStreams& streams, TelemetryTransport& transport,
                  auth::Principal caller)
      : context_(context), streams_(streams), transport_(transport), caller_(std::move(caller)) {}

  // Called first.
  void Accept();
  // Takes the message that was read, or null if it does not parse. What it held may be gone
  // then.
  void OnMessage(v1::StreamTelemetryRequest* request);
  // The client sends no more.
  void OnHalfClose();
  // A write has ended.
  void OnWritten(bool ok);
  // The connection is lost: pending reads and writes fail.
  void OnCancelled();
  // Called last: nothing is pending any more.
  void OnDone();

  // Ends the stream if the caller's token is not valid any more.
  void EndIfRefused();
  // Tells the client to reconnect after `delay_ms`, since the daemon is going away, and ends the
  // stream once its evidence is on disk.
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
  // Counts the stream among those of its address. Error: RESOURCE_EXHAUSTED.
  absl::Status CountAddress();
  void OnHelloOverdue();
  // Error: RESOURCE_EXHAUSTED (more messages of the stream than RpcOptions::max_messages_per_s, or
  // Hellos of its token or address than max_hellos_per_s).
  absl::Status CountMessage(const v1::StreamTelemetryRequest& request);
  absl::Status Dispatch(v1::StreamTelemetryRequest& request);
  absl::Status Open(v1::Hello& hello);
  void OnOpened(const absl::StatusOr<sessions::OpenedSession>& opened);
  // Counts a session that begins without all of the store's evidence. Logs a warning at most once a
  // minute for all streams.
  void ReportMissingEvidence(const absl::Status& status);
  void Enter(const sessions::OpenedSession& opened);
  void Reject(const absl::Status& status);
  // What the next write sends.
  v1::StreamTelemetryResponse& Outbox();
  v1::StreamTelemetryResponse TakeOutbox();
  // Drops what is to be sent.
  void ClearOutbox();
  void WriteNext();
  void LeaveSession();
  // The client has ended the session: later messages are ignored, earlier ones go to the disk.
  bool SaidGoodbye() const;

  ServiceContext& context_;
  TelemetryStreams& streams_;
  TelemetryTransport& transport_;
  const auth::Principal caller_;
  uint64_t number_ = 0;  // in streams_
  std::string address_;  // under which streams_ counts it; empty if not
  std::shared_ptr<sessions::GameSession> session_;
  std::shared_ptr<sessions::SessionOpening> opening_;  // from Hello until there is a session
  sessions::Telemetry telemetry_;                      // reused
  double time_scale_ = 1;                              // of the Hello
  uint32_t decision_interval_ms_ = 0;
  uint32_t batch_interval_ms_ = 0;  // the latest one that the client got
  auth::RateBucket messages_;
  // What is to be sent with the next write. Only the latest of each kind is kept, so that a client
  // that reads slowly gets the newest state and costs one response.
  v1::StreamTelemetryResponse outbox_;
  bool has_outbox_ = false;
  bool writing_ = false;
  std::optional<absl::Status> end_;  // the stream ends with it once the outbox is empty
  bool finished_ = false;
};

}  // namespace sweepstake::rpc
