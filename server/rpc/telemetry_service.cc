#include "server/rpc/telemetry_service.h"

#include <set>

namespace sweepstake::rpc {

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* TelemetryService::StreamTelemetry(
    grpc::CallbackServerContext* call) {
  return TelemetryStream::Start(context_, streams_, *call);
}

void TelemetryService::Drain() {
  streams_.draining = true;
  const std::set<TelemetryStream*> streams = streams_.all;
  for (TelemetryStream* stream : streams) stream->Drain();
}

}  // namespace sweepstake::rpc
