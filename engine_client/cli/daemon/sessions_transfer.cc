#include "engine_client/cli/daemon/sessions_transfer.h"

#include <utility>

#include "engine_client/cli/daemon/daemon_client.h"
#include "sweepstake/v1/sessions.grpc.pb.h"

namespace sweepstake::cli {

Result<std::vector<v1::SessionInfo>> ListSessions(const DaemonOptions& daemon,
                                                  const std::string& project,
                                                  const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  std::vector<v1::SessionInfo> sessions;
  v1::ListSessionsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  do {
    auto page = Call(daemon, channel, request, &v1::SessionsService::Stub::ListSessions);
    if (!page.ok()) return page.status();
    for (v1::SessionInfo& each : *page->mutable_sessions()) sessions.push_back(std::move(each));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

Status WatchSessions(const DaemonOptions& daemon, const std::string& project,
                     const std::string& scene, const std::function<bool()>& is_stopped,
                     const std::function<void(const v1::WatchSessionsResponse&)>& on_event,
                     const std::function<void(const Status&)>& on_connection) {
  v1::WatchSessionsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  return KeepWatching(
      daemon, is_stopped, on_connection,
      [&](const std::shared_ptr<grpc::Channel>& channel, const std::function<bool()>& ends) {
        const auto stub = v1::SessionsService::NewStub(channel);
        grpc::ClientContext context;
        return ReadEvents(context, *stub->WatchSessions(&context, request), daemon, ends, on_event);
      });
}

Status KickSession(const DaemonOptions& daemon, const std::string& session_id, bool may_return) {
  v1::KickSessionRequest request;
  request.set_session_id(session_id);
  request.set_may_return(may_return);
  return Call(daemon, OpenChannel(daemon), request, &v1::SessionsService::Stub::KickSession)
      .status();
}

Result<v1::OrderSessionResponse> OrderSession(const DaemonOptions& daemon,
                                              const std::string& session_id, v1::Mode mode,
                                              const std::string& arm) {
  v1::OrderSessionRequest request;
  request.set_session_id(session_id);
  request.set_mode(mode);
  request.set_arm(arm);
  return Call(daemon, OpenChannel(daemon), request, &v1::SessionsService::Stub::OrderSession);
}

}  // namespace sweepstake::cli
