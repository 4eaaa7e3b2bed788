#include "server/rpc/services/sessions_service.h"

#include <spdlog/logger.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "engine_client/text/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/end_call.h"
#include "server/rpc/services/watch_call.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {
namespace {

// Describes the order for the log, as the rest of a sentence whose subject is the operator.
std::string OrderText(const v1::OrderSessionRequest& order, const std::string& session_id) {
  const std::string text = absl::StrCat("ordered session ", session_id);
  if (order.mode() == v1::MODE_AI) return text + " to let the daemon decide";
  return text + (order.arm().empty() ? " to keep its arm" : " to keep to " + order.arm());
}

// Converts the request to an order. The caller sets its operator_name and now_ns.
absl::StatusOr<decision::OrderReport> OrderOf(const v1::OrderSessionRequest& request,
                                              const std::vector<std::string>& arms) {
  if (request.mode() != v1::MODE_MANUAL && request.mode() != v1::MODE_AI) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "mode is absent or unknown; set MODE_MANUAL or MODE_AI");
  }
  decision::OrderReport order;
  order.mode = FromProto(request.mode());
  if (request.arm().empty()) return order;
  if (order.mode != Mode::kManual) {
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   "leave arm absent with MODE_AI: the decider chooses it");
  }
  const auto arm = std::find(arms.begin(), arms.end(), request.arm());
  if (arm == arms.end()) {
    const std::vector<std::string_view> valid(arms.begin(), arms.end());
    return Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                   text::UnknownName("arm", request.arm(), valid));
  }
  order.arm = static_cast<uint32_t>(arm - arms.begin());
  return order;
}

// Returns the session if it is in memory and has not ended. For a session of a project that the
// caller may not use, it also returns null, so that the answer does not reveal that the session
// exists.
std::shared_ptr<sessions::GameSession> FindFor(const ServiceContext& context,
                                               const auth::Principal& caller,
                                               const std::string& session_id) {
  std::shared_ptr<sessions::GameSession> session = context.sessions.Find(session_id);
  const bool shown =
      session != nullptr && !session->ended() && caller.MayUse(session->identity().scene.project);
  return shown ? session : nullptr;
}

}  // namespace

void Answer(ServiceContext& context, const Caller& caller, const v1::ListSessionsRequest& request,
            v1::ListSessionsResponse& response, const EndCall& end) {
  priors::SceneFilter filter{request.project(), request.scene()};
  if (const absl::Status allowed = Narrow(caller, filter); !allowed.ok()) return end(allowed);
  context.loop.Post([&context, &request, &response, filter = std::move(filter), end] {
    const uint32_t limit = request.page_size() == 0
                               ? kSessionsPerPage
                               : std::min(request.page_size(), kSessionsPerPage);
    for (const sessions::SessionView& session :
         context.sessions.List(filter, request.page_token(), limit)) {
      ToProto(session, *response.add_sessions());
    }
    if (response.sessions_size() == static_cast<int>(limit))
      response.set_next_page_token(response.sessions().rbegin()->session_id());
    end(absl::OkStatus());
  });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::KickSessionRequest& request,
            v1::KickSessionResponse& /*response*/, const EndCall& end) {
  context.loop.Post([&context, &request, caller, end] {
    const std::shared_ptr<sessions::GameSession> session =
        FindFor(context, caller, request.session_id());
    if (session == nullptr) return end(sessions::UnknownSession());
    const sessions::SessionIdentity& identity = session->identity();
    context.sessions.Kick(*session, request.may_return());
    const std::string who = NameAndAddress(caller);
    const std::string action = absl::StrCat(
        "kicked session ", identity.id, " of ", identity.scene.project, "/", identity.scene.scene,
        request.may_return() ? ", which may return" : ", which may not return");
    context.log.warn("{} {}", who, action);
    context.admin.Record(who, action);
    end(absl::OkStatus());
  });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::OrderSessionRequest& request,
            v1::OrderSessionResponse& response, const EndCall& end) {
  context.loop.Post([&context, &request, &response, caller, end] {
    const std::shared_ptr<sessions::GameSession> session =
        FindFor(context, caller, request.session_id());
    if (session == nullptr) return end(sessions::UnknownSession());
    auto order = OrderOf(request, session->identity().arms);
    if (!order.ok()) return end(order.status());
    const std::string who = NameAndAddress(caller);
    order->operator_name = who;
    order->now_ns = context.loop.clock().NowNs();
    // Record the order before the game answers, because the daemon may end before that. The
    // session's own audit log has the order only after the session's next decision is on disk.
    const std::string action = OrderText(request, session->identity().id);
    context.admin.Record(who, action);
    session->Order(*order, [&context, &response, who, end, action,
                            &decisions = session->decisions()](const absl::Status& status) {
      context.admin.Record(who, status.ok() ? absl::StrCat(action, ", and the game executed it")
                                            : absl::StrCat(action, ", which was refused: ",
                                                           NameOf(ReasonOfRefusal(status))));
      if (status.ok()) {
        context.log.info("{} {}", who, action);
        response.set_mode(static_cast<v1::Mode>(decisions.mode()));
        response.set_active_arm(decisions.arms()[decisions.active_arm()]);
      }
      end(status);
    });
  });
}

}  // namespace sweepstake::rpc
