// sweepstake.v1.TelemetryService on raw messages: it serves the stream of each game. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <set>

#include "server/rpc/services/service_context.h"
#include "server/rpc/sessions/game_session.h"
#include "server/rpc/sessions/session_start.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::rpc {

// The messages that a stream has yet to write. Only the latest of each kind is kept, so that a
// client that reads slowly gets the newest state and costs at most six messages. Not thread-safe.
class TelemetryOutbox {
 public:
  // Replaces an unsent message of the same kind. REQUIRES: the response has a message.
  void Put(v1::StreamTelemetryResponse response);
  // Removes and returns the most urgent message, in this order: welcome, switch command,
  // acknowledgement, snapshot, reconnect, order.
  std::optional<v1::StreamTelemetryResponse> Take();
  void Clear() { slots_ = {}; }

 private:
  // The kinds of StreamTelemetryResponse.message, numbered from 1 in order of urgency.
  static constexpr size_t kKinds = 6;
  std::array<std::optional<v1::StreamTelemetryResponse>, kKinds> slots_;
};

class TelemetryStream;

// All streams. Used on the decision loop only.
struct TelemetryStreams {
  std::set<TelemetryStream*> all;
  bool draining = false;
  int64_t next_store_warning_ns = std::numeric_limits<int64_t>::min();
};

// One connection of one session. It parses bytes into messages, passes them to the session, and
// sends the session's messages.
//
// gRPC's callbacks run on its few threads and only parse and post; everything else happens on the
// decision loop. Only one message at a time is between the socket and the session: the next read
// starts after the session has applied the last message, so that a flood waits in the client's own
// buffers. Messages are parsed here, from raw bytes into reused memory, because gRPC would report
// an invalid one as an orderly half-close. At most one write is pending, and the outbox behind it
// is bounded. Finish is called exactly once, whatever ends the stream.
//
// It owns itself from Start until gRPC is done with it.
class TelemetryStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                              public SessionLink,
                              public std::enable_shared_from_this<TelemetryStream> {
 public:
  static TelemetryStream* Start(ServiceContext& context, TelemetryStreams& streams,
                                grpc::CallbackServerContext& call);

  // Tells the client to reconnect after `delay_ms`, since the daemon is going away, and ends the
  // stream once its evidence is on disk.
  void Drain(uint32_t delay_ms);

  void SendSwitch(const decision::SwitchCommand& command) override;
  void SendAcknowledgement(uint64_t sequence) override;
  void SendSnapshot(std::span<const decision::BetaPosterior> posteriors,
                    const decision::Diagnosis& diagnosis) override;
  void SendReconnect(uint32_t delay_ms) override;
  void SendOrder(uint64_t order_id, const decision::OrderReport& order) override;
  void Close(const absl::Status& status) override;
  void Abort(const absl::Status& status) override;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  TelemetryStream(ServiceContext& context, TelemetryStreams& streams,
                  grpc::CallbackServerContext& call)
      : context_(context), streams_(streams), call_(call) {}

  // These run on the loop.
  void Accept();
  void OnHelloOverdue();
  void OnMessage(bool parsed);
  absl::Status Dispatch();
  absl::Status Open(const v1::Hello& given);
  // Returns the session in memory that the Hello resumes, or null. If there is one that it may not
  // resume, the Hello forgets its id.
  std::shared_ptr<GameSession> FindSession();
  absl::Status Load();
  void OnLoadOverdue();
  void OnLoaded(const StoredStart& start);
  absl::Status Begin(const StoredStart& start);
  // Counts a session that begins without all of the store's evidence, and says so in the log, at
  // most once a minute for all streams.
  void ReportMissingEvidence(const absl::Status& status);
  void Enter(std::shared_ptr<GameSession> session, bool resumed);
  void OnHalfClose();
  void OnWritten(bool ok);
  void Reject(const absl::Status& status);
  void Send(v1::StreamTelemetryResponse response);
  void WriteNext();
  void LeaveSession();
  void FinishOnce();

  ServiceContext& context_;
  TelemetryStreams& streams_;
  grpc::CallbackServerContext& call_;
  std::shared_ptr<TelemetryStream> self_;  // keeps this object alive until OnDone

  // gRPC's callback uses these while a read is pending, the loop otherwise.
  grpc::ByteBuffer read_bytes_;
  v1::StreamTelemetryRequest request_;

  // These are used on the loop.
  std::shared_ptr<GameSession> session_;
  // The Hello as received, with the policy filled in and without the id of a session that it may
  // not resume. If session_ is null, the session is being loaded.
  std::optional<v1::Hello> hello_;
  TelemetryOutbox outbox_;
  grpc::ByteBuffer write_bytes_;
  bool writing_ = false;
  std::optional<absl::Status> end_;  // the stream ends with it once the outbox is empty
  bool finished_ = false;
};

// Returns the delay after which a drained client is to come back. Ranks are those of all clients,
// from 0.
uint32_t ReconnectDelayMs(const RpcOptions& options, uint64_t rank);

class TelemetryService final : public v1::TelemetryService::WithRawCallbackMethod_StreamTelemetry<
                                   v1::TelemetryService::Service> {
 public:
  explicit TelemetryService(ServiceContext& context) : context_(context) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamTelemetry(
      grpc::CallbackServerContext* call) override;

  // Refuses new streams and tells the others to reconnect later. Called on the loop.
  void Drain();

 private:
  ServiceContext& context_;
  TelemetryStreams streams_;
};

}  // namespace sweepstake::rpc
