// A gRPC call of a method with one request and a finite answer (served_methods.h).
#pragma once

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <optional>

#include "absl/status/status.h"
#include "server/rpc/services/served_methods.h"

namespace sweepstake::rpc {

// Reads the request and serves it. Deletes itself after OnDone.
class OneRequestCall final : public grpc::ServerGenericBidiReactor {
 public:
  OneRequestCall(ServiceContext& context, const ServedMethod& method,
                 grpc::CallbackServerContext& call, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  // Both run on any thread.
  void Write(const google::protobuf::Message& response, std::shared_ptr<bool> taken);
  void End(const absl::Status& status);

  ServiceContext& context_;
  const ServedMethod& method_;
  grpc::CallbackServerContext& call_;
  const Caller caller_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  std::shared_ptr<bool> taken_;  // of the pending write
  std::mutex mutex_;             // guards the members below
  bool is_writing_ = false;
  bool has_last_ = false;            // response_ is the only response, sent with the status
  std::optional<grpc::Status> end_;  // waits for the pending write
};

}  // namespace sweepstake::rpc
