// Calls the daemon's own services, in its process, for HTTP clients. Callbacks run on the thread of
// the HTTP server. A stream is read as fast as its owner requests messages.
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
  std::string caller;                // the address of the HTTP client in gRPC's format
  std::optional<std::string> token;  // printable ASCII
};

class Upstream {
 public:
  class Call;

  // An open stream. Destroying this object cancels it. Used on the context's thread.
  class Stream {
   public:
    explicit Stream(std::shared_ptr<Call> call) : call_(std::move(call)) {}
    ~Stream();
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    // Requests the next message. REQUIRES: the previous one has arrived.
    void Read();

   private:
    const std::shared_ptr<Call> call_;
  };

  using OnMessage = std::function<void(grpc::ByteBuffer)>;
  using OnEnd = std::function<void(const absl::Status&)>;
  using OnAnswer = std::function<void(const absl::Status&, grpc::ByteBuffer)>;

  // `caller_key` is the metadata that contains the caller. The context must outlive this object.
  // The destructor ends all calls; the context's thread must have ended by then.
  Upstream(std::shared_ptr<grpc::Channel> channel, std::string caller_key,
           boost::asio::io_context& io)
      : channel_(std::move(channel)), caller_key_(std::move(caller_key)), io_(io) {}
  ~Upstream();

  // Calls a method with one answer.
  void Ask(UpstreamRequest request, OnAnswer on_answer);
  // Calls a method with any number of answers. `on_message` receives each requested message.
  // `on_end` is called last, and once. Neither is called after the stream is destroyed.
  std::unique_ptr<Stream> Open(UpstreamRequest request, OnMessage on_message, OnEnd on_end);

 private:
  void Start(const std::shared_ptr<Call>& call, UpstreamRequest request);
  void Remove(Call* call);

  const std::shared_ptr<grpc::Channel> channel_;
  const std::string caller_key_;
  boost::asio::io_context& io_;
  std::mutex mutex_;  // guards calls_
  std::condition_variable removed_;
  std::set<Call*> calls_;
};

}  // namespace sweepstake::web
