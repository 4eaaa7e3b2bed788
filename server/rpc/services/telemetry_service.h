// sweepstake.v1.TelemetryService: serves the telemetry stream of each game. gRPC passes the
// messages unparsed. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include "server/rpc/services/service_context.h"
#include "server/rpc/services/telemetry_stream.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::rpc {

class TelemetryService final : public v1::TelemetryService::WithRawCallbackMethod_StreamTelemetry<
                                   v1::TelemetryService::Service> {
 public:
  explicit TelemetryService(ServiceContext& context) : context_(context) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamTelemetry(
      grpc::CallbackServerContext* call) override;

  // Refuses new streams and requests the connected clients to reconnect later. Called on the loop.
  void Drain() { streams_.Drain(context_.options); }
  // Ends the streams of callers whose tokens are no longer valid. Called on the loop.
  void EndRefused() { streams_.EndRefused(); }

 private:
  ServiceContext& context_;
  TelemetryStreams streams_;  // used on the loop
};

}  // namespace sweepstake::rpc
