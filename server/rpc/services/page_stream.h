// A response stream that is read from the store page by page, as fast as the client reads, one page
// ahead of the page that is written. Every streaming export uses it. It ends with DEADLINE_EXCEEDED
// if it makes no progress for RpcOptions::watcher_patience_ns, or is not done within
// transfer_patience_ns. AccessControl limits the number of exports.
//
// Used on the decision loop; gRPC's callbacks run elsewhere and only post to the loop. It owns
// itself until gRPC is done with it; results of the store reach it through a weak pointer.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

// `Place` is where the next page begins. It is copied to the store's thread.
template <typename Response, typename Place>
struct StreamPage {
  Response response{};
  Place next{};
  bool empty = false;  // the response is not sent, and the stream ends
  bool last = false;   // the stream ends after this response
};

template <typename Response, typename Place>
class PageStream final : public grpc::ServerWriteReactor<Response>,
                         public StallingCall,
                         public std::enable_shared_from_this<PageStream<Response, Place>> {
 public:
  using Page = StreamPage<Response, Place>;
  // Reads the page that begins at the place. It runs on the store's reading thread.
  using Load = std::function<absl::StatusOr<Page>(priors::PriorReader&, const Place&)>;

  // The stream ends when the caller's token is revoked or expires.
  static PageStream* Start(ServiceContext& context, grpc::CallbackServerContext& call,
                           auth::Principal caller, Load load) {
    std::shared_ptr<PageStream> stream(
        new PageStream(context, call, std::move(caller), std::move(load)));
    PageStream* raw = stream.get();
    raw->self_ = std::move(stream);
    context.loop.Post([raw] { raw->Begin(); });
    return raw;
  }

  void OnWriteDone(bool ok) override {
    context_.loop.Post([this, ok] { OnWritten(ok); });
  }
  // A pending write fails, and so does the next one, so the stream ends soon.
  void OnCancel() override {}
  void OnDone() override {
    context_.loop.Post([this] { self_.reset(); });
  }
  int64_t waiting_since_ns() const override { return last_progress_ns_; }
  int64_t deadline_ns() const override { return deadline_ns_; }
  void OnStalled() override {
    context_.stalls.Remove(*this);
    const absl::Status stalled =
        Refused(v1::ERROR_REASON_CALL_STALLED,
                "the answer was not read, or not in time; ask again, for less");
    context_.access.refusals().TellEnd(CallerOf(call_), stalled);
    Cancel(call_, ToGrpc(stalled, context_.counters));
  }

 private:
  PageStream(ServiceContext& context, grpc::CallbackServerContext& call, auth::Principal caller,
             Load load)
      : context_(context), call_(call), caller_(std::move(caller)), load_(std::move(load)) {}

  void Begin() {
    last_progress_ns_ = context_.loop.clock().NowNs();
    deadline_ns_ = last_progress_ns_ + context_.options.transfer_patience_ns;
    context_.stalls.Add(*this);
    auto transfer = context_.access.BeginTransfer(caller_, v1::ERROR_REASON_TOO_MANY_READS);
    if (!transfer.ok()) return End(transfer.status());
    transfer_ = *std::move(transfer);
    LoadNext();
  }

  // At most one page is being read or waits to be written.
  void LoadNext() {
    const bool submitted =
        context_.store.Read([weak = this->weak_from_this(), &loop = context_.loop, load = load_,
                             place = page_.next](priors::PriorReader& store) {
          if (weak.expired()) return;  // it ended while the previous page was written
          loop.Post([weak, page = load(store, place)]() mutable {
            if (!page.ok()) page = StoreFailed(page.status());
            if (const auto self = weak.lock()) self->OnPage(std::move(page));
          });
        });
    if (!submitted) {
      OnPage(Refused(v1::ERROR_REASON_STORE_BUSY,
                     "the prior store has too much to do; ask again later"));
    }
  }

  void OnPage(absl::StatusOr<Page> page) {
    ahead_ = std::move(page);
    if (!writes_ && !ended_) WriteNext();
  }

  void WriteNext() {
    if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
      return End(still);
    auto next = *std::exchange(ahead_, std::nullopt);
    if (!next.ok()) return End(next.status());
    page_ = *std::move(next);
    if (page_.empty) return End(absl::OkStatus());
    writes_ = true;
    this->StartWrite(&page_.response);
    if (!page_.last) LoadNext();
  }

  void OnWritten(bool ok) {
    last_progress_ns_ = context_.loop.clock().NowNs();
    writes_ = false;
    if (!ok) return End(absl::CancelledError("the connection was lost"));
    if (page_.last) return End(absl::OkStatus());
    if (ahead_) WriteNext();
  }

  void End(const absl::Status& status) {
    ended_ = true;
    context_.stalls.Remove(*this);  // gRPC frees the call once it is finished
    context_.access.refusals().TellEnd(CallerOf(call_), status);
    this->Finish(ToGrpc(status, context_.counters));
  }

  ServiceContext& context_;
  grpc::CallbackServerContext& call_;
  const auth::Principal caller_;
  const Load load_;
  std::shared_ptr<PageStream> self_;           // keeps this object alive until OnDone
  Page page_;                                  // the page that is written, or was written last
  std::optional<absl::StatusOr<Page>> ahead_;  // the page after it
  bool writes_ = false;
  bool ended_ = false;
  AccessControl::Share transfer_;
  int64_t last_progress_ns_ = 0;
  int64_t deadline_ns_ = sessions::Clock::kNever;
};

}  // namespace sweepstake::rpc
