#include "server/rpc/services/posterior_watcher.h"

#include <string>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/watcher_set.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {

PosteriorWatcher* PosteriorWatcher::Start(ServiceContext& context,
                                          grpc::CallbackServerContext& call,
                                          grpc::ByteBuffer request, auth::Principal caller) {
  std::shared_ptr<PosteriorWatcher> watcher(new PosteriorWatcher(context, call, std::move(caller)));
  PosteriorWatcher* raw = watcher.get();
  raw->self_ = std::move(watcher);
  context.loop.Post([raw, bytes = std::move(request)] { raw->Begin(bytes); });
  return raw;
}

void PosteriorWatcher::Begin(grpc::ByteBuffer request) {
  v1::WatchPosteriorsRequest wanted;
  if (!Parse(request, wanted))
    return Close(Refused(v1::ERROR_REASON_MALFORMED_MESSAGE, "the request does not parse"));
  filter_ = {wanted.project(), wanted.scene()};
  if (const absl::Status allowed = Narrow(caller_, filter_); !allowed.ok()) return Close(allowed);
  if (const absl::Status added = context_.watchers.Add(*this); !added.ok()) return Close(added);
  context_.stalls.Add(*this);
  LoadPage();
}

bool PosteriorWatcher::Watches(const priors::SceneKey& scene) const {
  return filter_.Matches(scene.project, scene.scene);
}

void PosteriorWatcher::OnDecision(const grpc::ByteBuffer& event) {
  if (end_) return;
  if (decision_bytes_ + event.Length() > kWatcherQueueBytes) {
    std::erase_if(events_, [](const Event& waiting) { return waiting.decision.has_value(); });
    decision_bytes_ = 0;
  }
  events_.push_back({.decision = event, .scene = {}});
  decision_bytes_ += event.Length();
  WriteNext();
}

void PosteriorWatcher::OnPosterior(const priors::SceneKey& scene, const grpc::ByteBuffer& event) {
  if (end_) return;
  const bool waits = !posteriors_.insert_or_assign(scene, event).second;
  if (!waits) events_.push_back({.decision = std::nullopt, .scene = scene});
  WriteNext();
}

void PosteriorWatcher::Resend() {
  stale_ = true;
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
    Close(Refused(v1::ERROR_REASON_STORE_BUSY,
                  "the prior store has too much to do; watch again later"));
}

void PosteriorWatcher::OnPage(const absl::StatusOr<std::vector<priors::SceneEvidence>>& page) {
  loading_ = false;
  if (end_) return;
  if (!page.ok()) return Close(StoreFailed(page.status()));
  for (const priors::SceneEvidence& scene : *page) {
    scenes_.push_back(context_.watchers.Encode(scene));
    posteriors_.erase(scene.key);  // it is older than the page
  }
  page_wanted_ = page->size() == kScenesPerPage;
  if (page_wanted_) last_of_page_ = page->back().key;
  WriteNext();
}

std::optional<grpc::ByteBuffer> PosteriorWatcher::TakeNext() {
  if (!scenes_.empty()) {
    grpc::ByteBuffer next = std::move(scenes_.front());
    scenes_.pop_front();
    return next;
  }
  // An event must not be sent before the scenes that it changes.
  if (loading_ || page_wanted_ || stale_) return std::nullopt;
  return TakeEvent();
}

std::optional<grpc::ByteBuffer> PosteriorWatcher::TakeEvent() {
  while (!events_.empty()) {
    Event next = std::move(events_.front());
    events_.pop_front();
    if (next.decision) {
      decision_bytes_ -= next.decision->Length();
      return std::move(next.decision);
    }
    if (auto posterior = posteriors_.extract(next.scene)) return std::move(posterior.mapped());
  }
  return std::nullopt;
}

void PosteriorWatcher::WriteNext() {
  if (writing_ || finished_) return;
  if (end_) {
    finished_ = true;
    return Finish(ToGrpc(*end_, context_.counters));
  }
  if (std::optional<grpc::ByteBuffer> next = TakeNext()) {
    write_bytes_ = *std::move(next);
    writing_ = true;
    write_start_ns_ = context_.loop.clock().NowNs();
    StartWrite(&write_bytes_);
  } else if (!loading_ && (page_wanted_ || stale_)) {
    if (!page_wanted_) last_of_page_.reset();
    if (!page_wanted_) stale_ = false;
    page_wanted_ = false;
    LoadPage();
  }
}

void PosteriorWatcher::OnStalled() {
  Close(Refused(v1::ERROR_REASON_WATCHER_STALLED, "the watcher did not read; watch again"));
}

void PosteriorWatcher::EndIfRefused() {
  if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok()) Close(still);
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
  posteriors_.clear();
  context_.watchers.Remove(*this);
  context_.stalls.Remove(*this);
  if (writing_) {
    Cancel(call_, ToGrpc(status, context_.counters));  // OnWritten continues from there
    end_ = absl::CancelledError("the call was cut off");
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
    context_.stalls.Remove(*this);
    self_.reset();
  });
}

}  // namespace sweepstake::rpc
