#include "server/rpc/services/posterior_watcher.h"

#include <utility>

#include "server/rpc/services/watcher_set.h"

namespace sweepstake::rpc {

absl::Status PosteriorWatcher::Join() { return context().watchers.group().Add(*this); }

void PosteriorWatcher::Leave() { context().watchers.group().Remove(*this); }

void PosteriorWatcher::OnDecisions(const grpc::ByteBuffer& event) {
  if (closed()) return;
  if (decision_bytes_ + event.Length() > kWatcherQueueBytes) {
    std::erase_if(events_, [](const Event& waiting) { return waiting.decisions.has_value(); });
    decision_bytes_ = 0;
  }
  events_.push_back({.decisions = event, .scene = {}});
  decision_bytes_ += event.Length();
  WriteNext();
}

void PosteriorWatcher::OnPosterior(const priors::SceneKey& scene, const grpc::ByteBuffer& event) {
  if (closed()) return;
  const bool waits = !posteriors_.insert_or_assign(scene, Posterior{event, page_count_}).second;
  if (!waits) events_.push_back({.decisions = std::nullopt, .scene = scene});
  WriteNext();
}

void PosteriorWatcher::Resend() {
  stale_ = true;
  WriteNext();
}

std::optional<grpc::ByteBuffer> PosteriorWatcher::TakeNext() {
  if (!scenes_.empty()) {
    grpc::ByteBuffer next = std::move(scenes_.front());
    scenes_.pop_front();
    return next;
  }
  // An event must not be sent before the scenes that it changes.
  if (loading_) return std::nullopt;
  if (!page_wanted_ && !stale_) return TakeMark() ? context().watchers.EncodeMark() : TakeEvent();
  if (!std::exchange(page_wanted_, false)) {
    stale_ = false;
    last_of_page_.reset();
  }
  LoadPage();
  return std::nullopt;
}

std::optional<grpc::ByteBuffer> PosteriorWatcher::TakeEvent() {
  while (!events_.empty()) {
    Event next = std::move(events_.front());
    events_.pop_front();
    if (next.decisions) {
      decision_bytes_ -= next.decisions->Length();
      return std::move(next.decisions);
    }
    if (auto posterior = posteriors_.extract(next.scene))
      return std::move(posterior.mapped().event);
  }
  return std::nullopt;
}

void PosteriorWatcher::LoadPage() {
  const auto self = std::static_pointer_cast<PosteriorWatcher>(shared_from_this());
  ++page_count_;
  loading_ =
      context().store.Read([weak = std::weak_ptr(self), &loop = context().loop, filter = filter(),
                            after = last_of_page_](priors::PriorReader& store) {
        loop.Post([weak, page = ToProto(store.List(filter, after, kScenesPerPage))] {
          if (const auto watcher = weak.lock()) watcher->OnPage(page);
        });
      });
  if (!loading_) {
    Close(Refused(v1::ERROR_REASON_STORE_BUSY,
                  "the prior store has too much to do; watch again later"));
  }
}

void PosteriorWatcher::OnPage(const absl::StatusOr<std::vector<v1::ScenePosterior>>& page) {
  loading_ = false;
  if (closed()) return;
  if (!page.ok()) return Close(StoreFailed(page.status()));
  for (const v1::ScenePosterior& scene : *page) {
    // What came before the page was asked for is older than the page. What came since may be newer,
    // and takes the page's place.
    const auto waiting = posteriors_.extract(FromProto(scene));
    const bool newer = !waiting.empty() && waiting.mapped().page == page_count_;
    scenes_.push_back(newer ? waiting.mapped().event : context().watchers.Encode(scene));
  }
  page_wanted_ = page->size() == kScenesPerPage;
  if (page_wanted_) last_of_page_ = FromProto(page->back());
  WriteNext();
}

void PosteriorWatcher::Forget() {
  scenes_.clear();
  events_.clear();
  posteriors_.clear();
}

}  // namespace sweepstake::rpc
