#include "server/web/api/upstream.h"

#include <atomic>
#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/web/error_page.h"

namespace sweepstake::web {
namespace {

// An order waits up to five seconds for its game. A read of the store waits for the earlier ones.
constexpr std::chrono::seconds kAnswerPatience{30};

}  // namespace

// It keeps itself alive until gRPC is done with it.
class Upstream::Call final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             public std::enable_shared_from_this<Call> {
 public:
  explicit Call(Upstream& upstream) : upstream_(upstream), io_(upstream.io_) {}

  void Start(const std::shared_ptr<grpc::Channel>& channel, UpstreamRequest request) {
    self_ = shared_from_this();
    context_.AddMetadata(upstream_.caller_key_, request.caller);
    if (request.token)
      context_.AddMetadata("authorization", absl::StrCat("Bearer ", *request.token));
    message_ = std::move(request.message);
    grpc::GenericStub(channel).PrepareBidiStreamingCall(&context_, request.path, {}, this);
    AddHold();  // reads are requested later, on the server's thread
    held_ = true;
    StartWriteLast(&message_, {});
    StartRead(&read_);
    StartCall();
  }
  void Read() { StartRead(&read_); }
  // Drops the callbacks and ends the call. Called on the context's thread, or after that thread has
  // ended.
  void Abandon() {
    on_message = {};
    on_end = {};
    context_.TryCancel();
    ReleaseHold();
  }
  grpc::ClientContext& context() { return context_; }

  void OnReadDone(bool ok) override {
    if (!ok) return ReleaseHold();
    boost::asio::post(io_, [self = self_, message = std::move(read_)]() mutable {
      // The callback may abandon the call.
      if (const OnMessage callback = self->on_message) callback(std::move(message));
    });
  }
  void OnDone(const grpc::Status& status) override {
    const std::shared_ptr<Call> self = std::move(self_);
    End(FromGrpc(status));
    upstream_.Remove(this);
  }
  // Reports how the call ended, or why it did not begin.
  void End(const absl::Status& status) {
    boost::asio::post(io_, [self = shared_from_this(), status] {
      self->on_message = {};
      if (const OnEnd callback = std::exchange(self->on_end, {})) callback(status);
    });
  }

  // Used on the context's thread.
  OnMessage on_message;
  OnEnd on_end;

 private:
  void ReleaseHold() {
    if (held_.exchange(false)) RemoveHold();
  }

  Upstream& upstream_;
  boost::asio::io_context& io_;
  std::shared_ptr<Call> self_;
  grpc::ClientContext context_;
  grpc::ByteBuffer message_;
  grpc::ByteBuffer read_;
  std::atomic<bool> held_{false};
};

Upstream::Stream::~Stream() { call_->Abandon(); }

void Upstream::Stream::Read() { call_->Read(); }

Upstream::~Upstream() {
  std::unique_lock lock(mutex_);
  std::vector<std::shared_ptr<Call>> calls;
  for (Call* call : calls_) calls.push_back(call->shared_from_this());
  lock.unlock();
  for (const auto& call : calls) call->Abandon();
  lock.lock();
  removed_.wait(lock, [this] { return calls_.empty(); });
}

void Upstream::Start(const std::shared_ptr<Call>& call, UpstreamRequest request) {
  {
    const std::lock_guard lock(mutex_);
    calls_.insert(call.get());
  }
  call->Start(channel_, std::move(request));
}

void Upstream::Remove(Call* call) {
  const std::lock_guard lock(mutex_);
  calls_.erase(call);
  removed_.notify_all();
}

void Upstream::Ask(UpstreamRequest request, OnAnswer on_answer) {
  const auto call = std::make_shared<Call>(*this);
  const auto answer = std::make_shared<grpc::ByteBuffer>();
  // Requesting another message makes gRPC report the end of the call.
  call->on_message = [answer, raw = call.get()](grpc::ByteBuffer message) {
    *answer = std::move(message);
    raw->Read();
  };
  call->on_end = [answer, callback = std::move(on_answer)](const absl::Status& status) {
    callback(status, std::move(*answer));
  };
  call->context().set_deadline(std::chrono::system_clock::now() + kAnswerPatience);
  Start(call, std::move(request));
}

std::unique_ptr<Upstream::Stream> Upstream::Open(UpstreamRequest request, OnMessage on_message,
                                                 OnEnd on_end) {
  const auto call = std::make_shared<Call>(*this);
  call->on_message = std::move(on_message);
  call->on_end = std::move(on_end);
  Start(call, std::move(request));
  return std::make_unique<Stream>(call);
}

}  // namespace sweepstake::web
