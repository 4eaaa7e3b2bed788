// Asks grpc.health.v1 how the server is, without a generated stub.
#pragma once

#include <grpcpp/grpcpp.h>
#include <grpcpp/impl/codegen/client_unary_call.h>

#include <memory>
#include <string>

namespace sweepstake::rpc {

enum class Health { kUnknown = 0, kServing = 1, kNotServing = 2 };

inline Health HealthOf(grpc::Channel& channel) {
  const grpc::internal::RpcMethod check("/grpc.health.v1.Health/Check",
                                        grpc::internal::RpcMethod::NORMAL_RPC);
  // The empty request asks for the whole server; the response's field 1 is the status.
  const grpc::ByteBuffer request(nullptr, 0);
  grpc::ClientContext context;
  grpc::ByteBuffer response;
  if (!grpc::internal::BlockingUnaryCall(&channel, check, &context, request, &response).ok())
    return Health::kUnknown;
  grpc::Slice bytes;
  if (!response.DumpToSingleSlice(&bytes).ok() || bytes.size() != 2) return Health::kUnknown;
  return static_cast<Health>(*(bytes.begin() + 1));
}

}  // namespace sweepstake::rpc
