#include "engine_client/cli/daemon/posteriors_transfer.h"
#include "engine_client/cli/daemon/daemon_client.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"

namespace sweepstake::cli {
Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  std::vector<v1::ScenePosterior> scenes;
  v1::ListPosteriorsRequest request;
  request.set_project(project);
  do {
    const auto page = Call(daemon, channel, request, &v1::PosteriorsService::Stub::ListPosteriors);
    if (!page.ok()) return page.status();
    for (const v1::ScenePosterior& each : page->scenes()) {
      if (scene.empty() || each.scene() == scene) scenes.push_back(each);
    }
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event,
                       const std::function<void(const Status&)>& on_connection) {
  v1::WatchPosteriorsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  return KeepWatching(
      daemon, is_stopped, on_connection,
      [&](const std::shared_ptr<grpc::Channel>& channel, const std::function<bool()>& ends) {
        const auto stub = v1::PosteriorsService::NewStub(channel);
        grpc::ClientContext context;
        return ReadEvents(context, *stub->WatchPosteriors(&context, request), daemon, ends,
                          on_event);
      });
}

}  // namespace sweepstake::cli
