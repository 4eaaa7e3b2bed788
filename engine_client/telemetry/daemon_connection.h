// One connection to the daemon, which carries the messages of a session.
//
// A connection is a bidirectional gRPC stream on its own channel. The owner polls it. gRPC's
// threads only put received messages into a bounded inbox and wake the owner; no function here
// waits, except the destructor. Each connection has its own channel, so that gRPC's own
// reconnection delays do not add to the session's back-off. Keep-alive pings detect a half-open
// connection within 30 s.
//
// Thread safety: all public methods and the destructor are called on the sender thread. They must
// never run on one of gRPC's threads: a channel that is destroyed on the thread that serves it
// destroys the queue that this thread is using (gRPC 1.51).
#pragma once

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "engine_client/telemetry/daemon_channel.h"

namespace sweepstake {

class DaemonConnection final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  // Maximum number of unread responses. When the inbox is full, reading pauses, and gRPC's flow
  // control slows down the daemon.
  static constexpr size_t kMaxInboxMessages = 64;

  // Returns a channel for one connection. Errors: those of MakeDaemonChannel.
  static Result<std::shared_ptr<grpc::Channel>> MakeChannel(const std::string& address,
                                                            const std::optional<TlsOptions>& tls,
                                                            const ClientToken& token,
                                                            const TlsNames& names);

  // Starts to connect over `channel`, which comes from MakeChannel and must not be used elsewhere.
  // `wake` is called on gRPC's threads whenever the state changes, until the destructor returns. It
  // must not block.
  DaemonConnection(std::shared_ptr<grpc::Channel> channel, std::function<void()> wake);
  // Cancels the stream and waits until gRPC releases it. This does not depend on an answer from the
  // daemon.
  ~DaemonConnection() override;

  // Returns whether Write may be called: the stream is open and no write is in flight.
  bool writable();
  // Starts to write a message. REQUIRES: writable(), and HalfClose was not called.
  void Write(const std::string& message);
  // Announces to the daemon that no more messages follow. REQUIRES: writable().
  void HalfClose();
  // Ends the stream at once. closed() has a value soon after.
  void Cancel();

  // Removes and returns the oldest response, or nullopt if there is none.
  std::optional<std::string> TakeResponse();
  // Returns the stream's final status. Returns nullopt while the stream is open or responses are
  // left in the inbox.
  std::optional<grpc::Status> closed();

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void LetGo();

  const std::function<void()> wake_;
  const std::shared_ptr<grpc::Channel> channel_;
  grpc::TemplatedGenericStub<grpc::ByteBuffer, grpc::ByteBuffer> stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer writing_;  // used while a write is in flight
  grpc::ByteBuffer read_;     // used while a read is in flight
  bool held_ = true;          // the owner may still start operations (gRPC's hold)

  std::mutex mutex_;  // guards the members below
  std::deque<std::string> inbox_;
  bool read_in_flight_ = true;
  bool write_in_flight_ = false;
  bool broken_ = false;                 // a read or write failed, so the stream has ended
  std::optional<grpc::Status> status_;  // present from OnDone on
  std::condition_variable done_;
};

}  // namespace sweepstake
