#include "server/rpc/services/posterior_watcher.h"

#include <grpc/grpc.h>

#include <string>
#include <utility>

#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/watch_hub.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {

PosteriorWatcher* PosteriorWatcher::Start(ServiceContext& context,
                                          grpc::CallbackServerContext& call,
                                          grpc::ByteBuffer request) {
  std::shared_ptr<PosteriorWatcher> watcher(new PosteriorWatcher(context, call));
  PosteriorWatcher* raw = watcher.get();
  raw->self_ = std::move(watcher);
  context.loop.Post([raw, bytes = std::move(request)] { raw->Begin(bytes); });
  return raw;
}

void PosteriorWatcher::Begin(grpc::ByteBuffer request) {
  v1::WatchPosteriorsRequest wanted;
  if (!Parse(request, wanted))
    return Close(absl::InvalidArgumentError("the request does not parse"));
  filter_ = {wanted.project(), wanted.scene()};
  if (const absl::Status added = context_.watchers.Add(*this); !added.ok()) return Close(added);
  LoadPage();
}

bool PosteriorWatcher::Watches(const priors::SceneKey& scene) const {
  return (filter_.project.empty() || filter_.project == scene.project) &&
         (filter_.scene.empty() || filter_.scene == scene.scene);
}

void PosteriorWatcher::OnEvent(const grpc::ByteBuffer& event) {
  if (end_) return;
  if (events_.size() >= kWatcherQueueEvents) {
    stale_ = true;
    events_.clear();
  } else if (!stale_) {
    events_.push_back(event);
  }
  WriteNext();
}

void PosteriorWatcher::Resend() {
  stale_ = true;
  events_.clear();
  WriteNext();
}

void PosteriorWatcher::LoadPage() {
  loading_ =
      context_.store.Submit([weak = weak_from_this(), &loop = context_.loop, filter = filter_,
                             after = last_of_page_](priors::PriorStore& store) {
        loop.Post([weak, page = store.List(filter, after, kScenesPerPage)] {
          if (const auto self = weak.lock()) self->OnPage(page);
        });
      });
  if (!loading_)
    Close(absl::UnavailableError("the prior store has too much to do; watch again later"));
}

void PosteriorWatcher::OnPage(const absl::StatusOr<std::vector<priors::SceneEvidence>>& page) {
  loading_ = false;
  if (end_) return;
  if (!page.ok()) return Close(page.status());
  for (const priors::SceneEvidence& scene : *page)
    scenes_.push_back(context_.watchers.Encode(scene));
  page_wanted_ = page->size() == kScenesPerPage;
  if (page_wanted_) last_of_page_ = page->back().key;
  WriteNext();
}

std::optional<grpc::ByteBuffer> PosteriorWatcher::TakeNext() {
  std::deque<grpc::ByteBuffer>& queue = scenes_.empty() ? events_ : scenes_;
  // An event must not be sent before the scenes that it changes.
  if (queue.empty() || (scenes_.empty() && (loading_ || page_wanted_ || stale_)))
    return std::nullopt;
  grpc::ByteBuffer next = std::move(queue.front());
  queue.pop_front();
  return next;
}

void PosteriorWatcher::WriteNext() {
  if (writing_ || finished_) return;
  if (end_) {
    finished_ = true;
    return Finish(ToGrpc(*end_));
  }
  if (std::optional<grpc::ByteBuffer> next = TakeNext()) {
    write_bytes_ = *std::move(next);
    writing_ = true;
    ++write_count_;
    StartWrite(&write_bytes_);
    GuardWrite();
  } else if (!loading_ && (page_wanted_ || stale_)) {
    if (!page_wanted_) last_of_page_.reset();
    if (!page_wanted_) stale_ = false;
    page_wanted_ = false;
    LoadPage();
  }
}

void PosteriorWatcher::GuardWrite() {
  const int64_t deadline_ns = context_.loop.clock().NowNs() + context_.options.watcher_patience_ns;
  context_.loop.PostAt(deadline_ns, [weak = weak_from_this(), write = write_count_] {
    const auto self = weak.lock();
    if (!self || !self->writing_ || self->write_count_ != write) return;
    self->Close(absl::ResourceExhaustedError("the watcher did not read; watch again"));
  });
}

void PosteriorWatcher::OnWritten(bool ok) {
  writing_ = false;
  if (!ok && !end_) end_ = absl::CancelledError("the connection was lost");
  WriteNext();
}

void PosteriorWatcher::Close(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  scenes_.clear();
  events_.clear();
  context_.watchers.Remove(*this);
  if (writing_) {
    // The pending write waits for a client that does not read. Cancelling ends it, and OnWritten
    // continues from there.
    grpc_call_cancel_with_status(call_.c_call(), static_cast<grpc_status_code>(status.code()),
                                 std::string(status.message()).c_str(), nullptr);
  }
  WriteNext();
}

void PosteriorWatcher::OnWriteDone(bool ok) {
  context_.loop.Post([this, ok] { OnWritten(ok); });
}

void PosteriorWatcher::OnCancel() {
  context_.loop.Post([this] { Close(absl::CancelledError("the connection was lost")); });
}

void PosteriorWatcher::OnDone() {
  context_.loop.Post([this] {
    context_.watchers.Remove(*this);
    self_.reset();
  });
}

}  // namespace sweepstake::rpc
