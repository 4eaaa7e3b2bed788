// sweepstake.v1.TelemetryService on raw messages, see telemetry_stream.h. Thread-safe.
#pragma once

#include "server/rpc/telemetry_stream.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::rpc {

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
