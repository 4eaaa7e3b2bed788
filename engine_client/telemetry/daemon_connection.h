// One connection to the daemon, and how long to wait before the next one.
//
// A connection is a bidirectional gRPC stream on a channel of its own, driven by polling. gRPC's
// threads only put what they receive into a bounded inbox and wake the owner; nothing here waits. A
// channel per connection keeps gRPC's own reconnection delays out of the session's back-off.
// Keep-alive pings find a half-open connection within 30 s.
//
// Thread safety: all public methods, the destructor included, belong to the sender thread. They
// must never run on one of gRPC's threads: a channel that is destroyed on the thread that serves it
// destroys the queue that this thread is using (gRPC 1.51).
#pragma once

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
#include "server/decision/math/hash.h"
#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake {

class DaemonConnection final
    : public grpc::ClientBidiReactor<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse> {
 public:
  // The maximum number of unread responses. At this number reading pauses, and flow control slows
  // the daemon down.
  static constexpr size_t kMaxInboxMessages = 64;

  // Returns a channel for one connection. Errors: those of MakeDaemonChannel.
  static Result<std::shared_ptr<grpc::Channel>> MakeChannel(const std::string& address,
                                                            const std::optional<TlsOptions>& tls,
                                                            const ClientToken& token,
                                                            const TlsNames& names);

  // Begins to connect over a channel of MakeChannel that nobody else has. `wake` is called from
  // gRPC's threads whenever there is something to look at, until the destructor returns; it must
  // not block.
  DaemonConnection(std::shared_ptr<grpc::Channel> channel, std::function<void()> wake);
  // Cancels the stream and waits until gRPC releases it, which needs no answer from the daemon.
  ~DaemonConnection() override;

  // Returns whether Write may be called: the stream is open and no write is in flight.
  bool writable();
  // REQUIRES: writable(), no HalfClose before.
  void Write(const v1::StreamTelemetryRequest& request);
  // Announces that there are no more writes. REQUIRES: writable().
  void HalfClose();
  // Ends the stream at once; closed() follows.
  void Cancel();

  // Takes the oldest response; the result is absent if there is none.
  std::optional<v1::StreamTelemetryResponse> TakeResponse();
  // Returns how the stream ended; it is absent until all responses have been taken.
  std::optional<grpc::Status> closed();

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void LetGo();

  const std::function<void()> wake_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::TelemetryService::Stub> stub_;
  grpc::ClientContext context_;
  v1::StreamTelemetryRequest writing_request_;    // used while a write is in flight
  v1::StreamTelemetryResponse reading_response_;  // used while a read is in flight
  bool held_ = true;                              // the owner may still start operations

  std::mutex mutex_;  // guards what follows
  std::deque<v1::StreamTelemetryResponse> inbox_;
  bool reading_ = true;
  bool writing_ = false;
  bool broken_ = false;                 // a read or write failed: the stream is at its end
  std::optional<grpc::Status> status_;  // present from OnDone on
  std::condition_variable done_;
};

// How long to wait before connecting again: exponential with full jitter, so that ten thousand
// clients of a restarted daemon do not all come back at once.
//
// The same seed gives the same delays. Not thread-safe.
class Backoff {
 public:
  // REQUIRES: 1 <= min_ms <= max_ms.
  Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed);

  // Returns a delay that is uniform in [0, bound]. The bound is min_ms at first and doubles with
  // each call, up to max_ms.
  uint32_t NextMs();
  // Returns the delay after an error that is likely to persist: uniform in the upper half of [0,
  // max_ms].
  uint32_t LongMs();
  // Returns a number that is uniform in [0, bound_ms].
  uint32_t JitterMs(uint32_t bound_ms);
  // Resets the bound to min_ms, to be called after a good connection.
  void Reset() { bound_ms_ = min_ms_; }

 private:
  const uint32_t min_ms_;
  const uint32_t max_ms_;
  uint32_t bound_ms_;
  math::SplitMix64 random_;
};

}  // namespace sweepstake
