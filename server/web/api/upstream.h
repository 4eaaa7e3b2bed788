// Calls of the daemon's own services, in its process, on behalf of those who speak HTTP. What is
// called and how it ends is told on the thread of the HTTP server.
//
// gRPC's threads only hand over what comes; a stream is read as fast as its owner asks. In process,
// gRPC 1.51 loses the details of about one in a hundred streams that the daemon ends: their code
// and message come, and the reason is empty.
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

// Has a call begun with a channel to the services. Returns false, and does nothing, if there is
// none any more.
using WithChannel =
    std::function<bool(const std::function<void(const std::shared_ptr<grpc::Channel>&)>& begin)>;

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
  Upstream(WithChannel with_channel, std::string caller_key, boost::asio::io_context& io)
      : with_channel_(std::move(with_channel)), caller_key_(std::move(caller_key)), io_(io) {}
  ~Upstream();

  // Calls a method with one answer.
  void Ask(UpstreamRequest request, OnAnswer on_answer);
  // Calls a method with any number of answers. `on_message` gets each that was asked for, `on_end`
  // how the call ended, last and once; neither is called once the stream is destroyed.
  std::unique_ptr<Stream> Open(UpstreamRequest request, OnMessage on_message, OnEnd on_end);

 private:
  void Start(const std::shared_ptr<Call>& call, UpstreamRequest request);
  void Remove(Call* call);

  const WithChannel with_channel_;
  const std::string caller_key_;
  boost::asio::io_context& io_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable removed_;
  std::set<Call*> calls_;
};

}  // namespace sweepstake::web
