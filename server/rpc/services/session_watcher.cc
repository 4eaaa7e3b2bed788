#include "server/rpc/services/session_watcher.h"

#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/sessions_service.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {

SessionWatcher* SessionWatcher::Start(ServiceContext& context, SessionsService& service,
                                      grpc::CallbackServerContext& call, priors::SceneFilter filter,
                                      auth::Principal caller) {
  auto* watcher = new SessionWatcher(context, service, call, std::move(filter), std::move(caller));
  context.loop.Post([watcher] { watcher->Begin(); });
  return watcher;
}

SessionWatcher::SessionWatcher(ServiceContext& context, SessionsService& service,
                               grpc::CallbackServerContext& call, priors::SceneFilter filter,
                               auth::Principal caller)
    : context_(context),
      service_(service),
      call_(call),
      filter_(std::move(filter)),
      caller_(std::move(caller)) {}

void SessionWatcher::EndIfRefused() {
  if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok()) Close(still);
}

void SessionWatcher::Begin() {
  if (const absl::Status added = service_.Add(*this); !added.ok()) return Close(added);
  context_.stalls.Add(*this);
  watch::SessionChanges all;
  context_.sessions.ForEach([&all](const GameSession& session) {
    all.insert({session.identity().id, {.scene = session.identity().scene}});
  });
  OnSessions(all);
}

void SessionWatcher::OnSessions(const watch::SessionChanges& changes) {
  for (const auto& [id, change] : changes) {
    if (filter_.Matches(change.scene.project, change.scene.scene))
      changes_.insert_or_assign(id, change);
  }
  WriteNext();
}

bool SessionWatcher::TakeNext() {
  while (!changes_.empty()) {
    const auto next = changes_.extract(changes_.begin());
    response_.Clear();
    if (next.mapped().end != watch::SessionEnd::kNone) {
      response_.mutable_ended()->set_session_id(next.key());
      response_.mutable_ended()->set_end(static_cast<v1::SessionEnd>(next.mapped().end));
      return true;
    }
    // Of one that has ended since, the end is told with the next changes.
    if (std::optional<v1::SessionInfo> session = context_.sessions.Describe(next.key())) {
      *response_.mutable_session() = *std::move(session);
      return true;
    }
  }
  return false;
}

void SessionWatcher::WriteNext() {
  if (writing_ || finished_) return;
  if (end_) {
    finished_ = true;
    return Finish(ToGrpc(*end_, context_.counters));
  }
  if (!TakeNext()) return;
  ToProto(context_.watch_hub.NextStamp(), *response_.mutable_stamp());
  writing_ = true;
  write_start_ns_ = context_.loop.clock().NowNs();
  StartWrite(&response_);
}

void SessionWatcher::OnStalled() {
  Close(Refused(v1::ERROR_REASON_WATCHER_STALLED, "the watcher did not read; watch again"));
}

void SessionWatcher::OnWritten(bool ok) {
  writing_ = false;
  if (!ok && !end_) end_ = absl::CancelledError("the connection was lost");
  WriteNext();
}

void SessionWatcher::Close(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  changes_.clear();
  service_.Remove(*this);
  context_.stalls.Remove(*this);
  if (writing_) {
    Cancel(call_, ToGrpc(status, context_.counters));  // OnWritten continues from there
    end_ = absl::CancelledError("the call was cut off");
  }
  WriteNext();
}

void SessionWatcher::OnWriteDone(bool ok) {
  context_.loop.Post([this, ok] { OnWritten(ok); });
}

void SessionWatcher::OnCancel() {
  context_.loop.Post([this] { Close(absl::CancelledError("the connection was lost")); });
}

void SessionWatcher::OnDone() {
  // All tasks posted before this one have run by then.
  context_.loop.Post([this] {
    service_.Remove(*this);
    context_.stalls.Remove(*this);
    delete this;
  });
}

}  // namespace sweepstake::rpc
