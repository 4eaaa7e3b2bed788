// sweepstake.v1.TelemetryService on raw messages: the stream of each game. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <array>
#include <memory>
#include <optional>
#include <set>

#include "server/rpc/services/service_context.h"
#include "server/rpc/sessions/game_session.h"
#include "server/rpc/sessions/session_start.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::rpc {

// What a stream still has to write: of each kind of message the latest only, so that a client that
// reads slowly gets the newest state and costs five messages at most. Not thread-safe.
class TelemetryOutbox {
 public:
  // Replaces an unsent message of the same kind. REQUIRES: the response has a message.
  void Put(v1::StreamTelemetryResponse response);
  // Takes the most urgent one, in this order: welcome, switch command, acknowledgement, snapshot,
  // reconnect.
  std::optional<v1::StreamTelemetryResponse> Take();
  void Clear() { slots_ = {}; }

 private:
  // The kinds of StreamTelemetryResponse.message, numbered from 1 in order of urgency.
  static constexpr size_t kKinds = 5;
  std::array<std::optional<v1::StreamTelemetryResponse>, kKinds> slots_;
};

class TelemetryStream;

// All streams. On the decision loop only.
struct TelemetryStreams {
  std::set<TelemetryStream*> all;
  bool draining = false;
};

// One connection of one session: bytes to messages, messages to the session, and back.
//
// gRPC's reactions run on its few threads and only parse and post; everything else happens on the
// decision loop. One message at a time is on its way from the socket to the session: the next read
// starts when the session has taken the last one, so a flood waits in the client's own buffers. A
// message is parsed here from raw bytes into reused memory, because gRPC would report one that does
// not parse as an orderly half-close. One write is in flight; the outbox behind it is bounded.
// Finish is called exactly once, whatever ends the stream.
//
// It owns itself from Start until gRPC is done with it.
class TelemetryStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                              public SessionLink,
                              public std::enable_shared_from_this<TelemetryStream> {
 public:
  static TelemetryStream* Start(ServiceContext& context, TelemetryStreams& streams,
                                grpc::CallbackServerContext& call);

  // Tells the client that the daemon goes away, and ends the stream when what it sent is on disk.
  void Drain();

  void SendSwitch(const decision::SwitchCommand& command) override;
  void SendAcknowledgement(uint64_t sequence) override;
  void SendSnapshot(std::span<const decision::BetaPosterior> posteriors,
                    const decision::Diagnosis& diagnosis) override;
  void SendReconnect(uint32_t delay_ms) override;
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

  // All of these on the loop.
  void OnMessage(bool parsed);
  absl::Status Dispatch();
  absl::Status Open(const v1::Hello& given);
  void OnLoaded(absl::StatusOr<StoredStart> start);
  absl::Status Enter(std::shared_ptr<GameSession> session, bool resumed);
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
  std::shared_ptr<TelemetryStream> self_;  // until OnDone

  // Owned by gRPC's reaction while a read is in flight, by the loop otherwise.
  grpc::ByteBuffer read_bytes_;
  v1::StreamTelemetryRequest request_;

  // On the loop.
  std::shared_ptr<GameSession> session_;
  // As received, with the policy filled in. While session_ is null, the session is being loaded.
  std::optional<v1::Hello> hello_;
  TelemetryOutbox outbox_;
  grpc::ByteBuffer write_bytes_;
  bool writing_ = false;
  std::optional<absl::Status> end_;  // the stream ends with it once the outbox is empty
  bool finished_ = false;
};

class TelemetryService final : public v1::TelemetryService::WithRawCallbackMethod_StreamTelemetry<
                                   v1::TelemetryService::Service> {
 public:
  explicit TelemetryService(ServiceContext& context) : context_(context) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamTelemetry(
      grpc::CallbackServerContext* call) override;

  // On the loop: refuses new streams and tells the others to come back later.
  void Drain();

 private:
  ServiceContext& context_;
  TelemetryStreams streams_;
};

}  // namespace sweepstake::rpc
