// One connection to the daemon: a bidirectional gRPC stream on a channel of its own, driven by
// polling.
//
// gRPC's threads only put what they receive into a bounded inbox and wake the owner; nothing here
// waits. A channel per connection keeps gRPC's own reconnection delays out of the session's
// back-off. Keep-alive pings find a half-open connection within 30 s.
//
// Thread safety: the public methods on one thread, the sender's. Ownership: gRPC keeps the object
// alive until it is done with it, so the owner may let go at any time after Cancel.
#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake {

class DaemonConnection final
    : public grpc::ClientBidiReactor<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse> {
 public:
  // Responses kept unread; then reading pauses, and the daemon's flow control holds the rest back.
  static constexpr size_t kInboxMax = 64;

  // Begins to connect. `wake` is called from gRPC's threads whenever there is something to look at;
  // it must not block and must outlive the connection's end.
  static std::shared_ptr<DaemonConnection> Open(const std::string& address,
                                                std::function<void()> wake);

  // Whether Write may be called: no write is in flight and the stream is open.
  bool writable();
  // REQUIRES: writable(), no HalfClose before.
  void Write(const v1::StreamTelemetryRequest& request);
  // No more writes. REQUIRES: writable().
  void HalfClose();
  // Ends the stream at once; closed() follows.
  void Cancel();

  // The oldest response not taken yet.
  std::optional<v1::StreamTelemetryResponse> TakeResponse();
  // The stream's end, once all responses were taken.
  std::optional<grpc::Status> closed();

 private:
  explicit DaemonConnection(std::function<void()> wake) : wake_(std::move(wake)) {}

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void LetGo();

  const std::function<void()> wake_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
  grpc::ClientContext context_;
  v1::StreamTelemetryRequest writing_request_;    // while a write is in flight
  v1::StreamTelemetryResponse reading_response_;  // while a read is in flight
  bool held_ = true;                              // the owner may still start operations

  std::mutex mutex_;  // guards what follows
  std::deque<v1::StreamTelemetryResponse> inbox_;
  bool reading_ = true;
  bool writing_ = false;
  bool broken_ = false;  // a read or write failed: the stream is at its end
  std::optional<grpc::Status> status_;
  std::shared_ptr<DaemonConnection> self_;  // until OnDone
};

}  // namespace sweepstake
