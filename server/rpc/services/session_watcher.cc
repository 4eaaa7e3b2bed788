#include "server/rpc/services/session_watcher.h"

#include <utility>

#include "server/rpc/services/sessions_service.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {

absl::Status SessionWatcher::Join() { return service_.watchers().Add(*this); }

void SessionWatcher::Leave() { service_.watchers().Remove(*this); }

void SessionWatcher::OnTick(std::shared_ptr<const SessionTick> tick) {
  if (closed()) return;
  if (!listed_until_ && !tick_ && changes_.empty()) {
    tick_ = std::move(tick);
    next_message_ = 0;
  } else {
    for (const auto& [id, change] : tick->changes) changes_.insert_or_assign(id, change);
  }
  WriteNext();
}

std::optional<grpc::ByteBuffer> SessionWatcher::TakeNext() {
  if (listed_until_) {
    if (std::optional<grpc::ByteBuffer> page = TakePage()) return page;
  }
  if (TakeMark()) {
    v1::WatchSessionsResponse mark;
    mark.set_all_told(true);
    ToProto(context().watch_hub.NextStamp(), *mark.mutable_stamp());
    return Serialize(mark);
  }
  if (tick_) {
    const grpc::ByteBuffer next = tick_->messages[next_message_];
    if (++next_message_ == tick_->messages.size()) tick_.reset();
    return next;
  }
  return service_.TakeMessage(changes_);
}

std::optional<grpc::ByteBuffer> SessionWatcher::TakePage() {
  v1::WatchSessionsResponse page;
  for (const sessions::SessionView& session :
       context().sessions.List(filter(), *listed_until_, kSessionsPerPage)) {
    ToProto(session, *page.add_sessions());
  }
  listed_until_.reset();
  if (page.sessions().empty()) return std::nullopt;
  if (page.sessions_size() == static_cast<int>(kSessionsPerPage))
    listed_until_ = page.sessions().rbegin()->session_id();
  ToProto(context().watch_hub.NextStamp(), *page.mutable_stamp());
  return Serialize(page);
}

void SessionWatcher::Forget() {
  tick_.reset();
  changes_.clear();
}

absl::Status BoxWatcher::Join() {
  const std::shared_ptr<sessions::GameSession> session = context().sessions.Find(session_id_);
  if (session == nullptr || session->ended()) return sessions::UnknownSession();
  const priors::SceneKey& scene = session->identity().scene;
  if (!filter().Matches(scene.project, scene.scene)) return sessions::UnknownSession();
  if (absl::Status added = service_.box_watchers().Add(*this); !added.ok()) return added;
  session_ = session;
  return session->boxes().Add(*this);
}

void BoxWatcher::Leave() {
  service_.box_watchers().Remove(*this);
  if (const std::shared_ptr<sessions::GameSession> session = session_.lock())
    session->boxes().Remove(*this);
  session_.reset();
}

void BoxWatcher::OnView(const sessions::BoxView& view) {
  v1::WatchBoxesResponse response;
  ToProto(view, *response.mutable_view());
  ToProto(context().watch_hub.NextStamp(), *response.mutable_stamp());
  newest_ = Serialize(response);
  WriteNext();
}

std::optional<grpc::ByteBuffer> BoxWatcher::TakeNext() {
  if (TakeMark()) {
    v1::WatchBoxesResponse mark;
    mark.set_all_told(true);
    ToProto(context().watch_hub.NextStamp(), *mark.mutable_stamp());
    return Serialize(mark);
  }
  return std::exchange(newest_, std::nullopt);
}

}  // namespace sweepstake::rpc
