// sweepstake.v1.TelemetryService: serves the telemetry stream of each game. gRPC passes the
// messages unparsed. Thread-safe.
#pragma once

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include "server/rpc/services/service_context.h"
#include "server/rpc/services/telemetry_stream.h"

namespace sweepstake::rpc {

class TelemetryService {
 public:
  explicit TelemetryService(ServiceContext& context) : context_(context) {}

  // Serves a call of StreamTelemetry.
  grpc::ServerGenericBidiReactor* Serve(grpc::CallbackServerContext& call, const Caller& caller);

  // Refuses new streams and requests the connected clients to reconnect later. Called on the loop.
  void Drain() { streams_.Drain(context_.options); }
  // Ends the streams of callers whose tokens are no longer valid. Called on the loop.
  void EndRefused() { streams_.EndRefused(); }

 private:
  ServiceContext& context_;
  TelemetryStreams streams_;  // used on the loop
};

}  // namespace sweepstake::rpc
