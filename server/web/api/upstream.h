// Calls of the daemon's own services, in its process, on behalf of those who speak HTTP. What is
// called and how it ends is told on the thread of the HTTP server.
//
// gRPC's threads only hand over what comes; a stream is read as fast as its owner asks.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <boost/asio/io_context.hpp>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"

namespace sweepstake::web {

struct UpstreamRequest {
  std::string path;  // Method::path
  grpc::ByteBuffer message;
  std::string caller;                // for whom, as gRPC names the other end
  std::optional<std::string> token;  // printable ASCII
};

class Upstream {
 public:
  class Call;

  // A stream whose owner wants more; it is cancelled with this object. Used on the context's
  // thread.
  class Stream {
   public:
    explicit Stream(std::shared_ptr<Call> call) : call_(std::move(call)) {}
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    // Asks for the next message. REQUIRES: the one before has come.
    void Read();

   private:
    const std::shared_ptr<Call> call_;
  };

  using OnMessage = std::function<void(grpc::ByteBuffer)>;
  using OnEnd = std::function<void(const absl::Status&)>;
  using OnAnswer = std::function<void(const absl::Status&, grpc::ByteBuffer)>;

  // `caller_key` is the metadata that names the caller. The context must outlive this object, and
  // its thread must have ended when this object does, which ends all calls.
  Upstream(std::shared_ptr<grpc::Channel> channel, std::string caller_key,
           boost::asio::io_context& io)
      : channel_(std::move(channel)), caller_key_(std::move(caller_key)), io_(io) {}
  ~Upstream();

  // Calls a method with one answer.
  void Ask(UpstreamRequest request, OnAnswer on_answer);
  // Calls a method with any number of answers. `on_message` gets each that was asked for, `on_end`
  // how the call ended, last and once; neither is called once the stream is destroyed.
  std::unique_ptr<Stream> Open(UpstreamRequest request, OnMessage on_message, OnEnd on_end);

 private:
  void Start(const std::shared_ptr<Call>& call, UpstreamRequest request);
  void Remove(Call* call);

  const std::shared_ptr<grpc::Channel> channel_;
  const std::string caller_key_;
  boost::asio::io_context& io_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable removed_;
  std::set<Call*> calls_;
};

}  // namespace sweepstake::web
