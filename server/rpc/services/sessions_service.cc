#include "server/rpc/services/sessions_service.h"

#include <spdlog/logger.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "server/decision/math/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/session_watcher.h"
#include "server/rpc/sessions/admin_log.h"
#include "server/rpc/sessions/session_table.h"

namespace sweepstake::rpc {
namespace {

absl::Status UnknownSession() {
  return Refused(v1::ERROR_REASON_UNKNOWN_SESSION,
                 "there is no such session in memory; list those that there are");
}

// The caller sets the operator and the time.
absl::StatusOr<decision::OrderReport> OrderOf(const v1::OrderSessionRequest& request,
                                              const std::vector<std::string>& arms) {
  if (request.mode() != v1::MODE_MANUAL && request.mode() != v1::MODE_AI) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "mode is absent or unknown; set MODE_MANUAL or MODE_AI");
  }
  decision::OrderReport order;
  order.mode = FromProto(request.mode());
  if (request.arm().empty()) return order;
  if (order.mode != decision::Mode::kManual) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "with MODE_AI the daemon chooses the arm; leave it absent");
  }
  const auto arm = std::find(arms.begin(), arms.end(), request.arm());
  if (arm == arms.end()) {
    const std::vector<std::string_view> valid(arms.begin(), arms.end());
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   math::UnknownName("arm", request.arm(), valid));
  }
  order.arm = static_cast<uint32_t>(arm - arms.begin());
  return order;
}

}  // namespace

grpc::ServerUnaryReactor* SessionsService::ListSessions(grpc::CallbackServerContext* call,
                                                        const v1::ListSessionsRequest* request,
                                                        v1::ListSessionsResponse* response) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  priors::SceneFilter wanted{request->project(), request->scene()};
  const auto caller = context_.access.Authorize(*call, RpcOf("SessionsService/ListSessions"));
  absl::Status allowed = caller.status();
  if (allowed.ok()) allowed = Narrow(*caller, wanted);
  if (!allowed.ok()) {
    reactor->Finish(ToGrpc(allowed, context_.counters));
    return reactor;
  }
  const uint32_t limit = request->page_size() == 0
                             ? kSessionsPerPage
                             : std::min(request->page_size(), kSessionsPerPage);
  context_.loop.Post(
      [this, reactor, response, limit, after = request->page_token(), filter = std::move(wanted)] {
        for (v1::SessionInfo& session : context_.sessions.List(filter, after, limit)) {
          *response->add_sessions() = std::move(session);
        }
        if (response->sessions_size() == static_cast<int>(limit))
          response->set_next_page_token(response->sessions().rbegin()->session_id());
        reactor->Finish(grpc::Status::OK);
      });
  return reactor;
}

grpc::ServerWriteReactor<v1::WatchSessionsResponse>* SessionsService::WatchSessions(
    grpc::CallbackServerContext* call, const v1::WatchSessionsRequest* request) {
  priors::SceneFilter wanted{request->project(), request->scene()};
  auto caller = context_.access.Authorize(*call, RpcOf("SessionsService/WatchSessions"));
  absl::Status allowed = caller.status();
  if (allowed.ok()) allowed = Narrow(*caller, wanted);
  if (!allowed.ok()) {
    return new RefusedCall<grpc::ServerWriteReactor<v1::WatchSessionsResponse>>(
        ToGrpc(allowed, context_.counters));
  }
  return SessionWatcher::Start(context_, *this, *call, std::move(wanted), *std::move(caller));
}

grpc::ServerUnaryReactor* SessionsService::KickSession(grpc::CallbackServerContext* call,
                                                       const v1::KickSessionRequest* request,
                                                       v1::KickSessionResponse* /*response*/) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  auto caller = context_.access.Authorize(*call, RpcOf("SessionsService/KickSession"));
  if (!caller.ok()) {
    reactor->Finish(ToGrpc(caller.status(), context_.counters));
    return reactor;
  }
  std::string who = NameAndAddress(*caller, *call);
  context_.loop.Post([this, reactor, caller = *std::move(caller), id = request->session_id(),
                      who = std::move(who), may_return = request->may_return()] {
    const std::shared_ptr<GameSession> session = context_.sessions.Find(id);
    absl::Status status;
    // Of another project's session the answer tells nothing.
    if (session == nullptr || session->ended() ||
        !caller.MayUse(session->identity().scene.project)) {
      status = UnknownSession();
    } else {
      context_.sessions.Kick(*session, may_return);
      context_.log.warn("{} kicked session {} of {}/{}, which {}", who, id,
                        session->identity().scene.project, session->identity().scene.scene,
                        may_return ? "may return" : "has ended");
      admin_.Record(absl::StrCat("action=kick session=", id, " may_return=", may_return), who);
    }
    reactor->Finish(ToGrpc(status, context_.counters));
  });
  return reactor;
}

grpc::ServerUnaryReactor* SessionsService::OrderSession(grpc::CallbackServerContext* call,
                                                        const v1::OrderSessionRequest* request,
                                                        v1::OrderSessionResponse* response) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  auto caller = context_.access.Authorize(*call, RpcOf("SessionsService/OrderSession"));
  if (!caller.ok()) {
    reactor->Finish(ToGrpc(caller.status(), context_.counters));
    return reactor;
  }
  std::string who = NameAndAddress(*caller, *call);
  context_.loop.Post([this, reactor, request, response, caller = *std::move(caller),
                      who = std::move(who)] {
    const std::shared_ptr<GameSession> session = context_.sessions.Find(request->session_id());
    if (session == nullptr || session->ended() || !caller.MayUse(session->identity().scene.project))
      return reactor->Finish(ToGrpc(UnknownSession(), context_.counters));
    auto order = OrderOf(*request, session->identity().arms);
    if (!order.ok()) return reactor->Finish(ToGrpc(order.status(), context_.counters));
    order->operator_name = who;
    order->now_ns = context_.loop.clock().NowNs();
    context_.log.info("{} orders session {}: {} {}", who, session->identity().id,
                      v1::Mode_Name(request->mode()), request->arm());
    // The session's own log has it, too, once its next decision is on disk.
    admin_.Record(absl::StrCat("action=order session=", session->identity().id,
                               " mode=", v1::Mode_Name(request->mode()), " arm=", request->arm()),
                  who);
    session->Order(*order, [this, reactor, response,
                            &decisions = session->decisions()](const absl::Status& status) {
      if (status.ok()) {
        response->set_mode(static_cast<v1::Mode>(decisions.mode()));
        response->set_active_arm(decisions.arms()[decisions.active_arm()]);
      }
      reactor->Finish(ToGrpc(status, context_.counters));
    });
  });
  return reactor;
}

void SessionsService::OnSessions(const watch::SessionChanges& changes) {
  for (auto next = watchers_.begin(); next != watchers_.end();) (*next++)->OnSessions(changes);
}

absl::Status SessionsService::Add(SessionWatcher& watcher) {
  if (draining_)
    return Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; watch again later");
  if (context_.counters.open_watcher_count >= context_.options.max_watchers) {
    return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                   "this daemon has as many watchers as it may; try again later");
  }
  watchers_.insert(&watcher);
  ++context_.counters.open_watcher_count;
  return absl::OkStatus();
}

void SessionsService::Remove(SessionWatcher& watcher) {
  context_.counters.open_watcher_count -= watchers_.erase(&watcher);
}

void SessionsService::EndRefused() {
  for (auto next = watchers_.begin(); next != watchers_.end();) (*next++)->EndIfRefused();
}

void SessionsService::Drain() {
  draining_ = true;
  for (auto next = watchers_.begin(); next != watchers_.end();) {
    (*next++)->Close(
        Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; watch again later"));
  }
}

}  // namespace sweepstake::rpc
