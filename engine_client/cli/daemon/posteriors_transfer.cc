#include "engine_client/cli/daemon/posteriors_transfer.h"

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "engine_client/cli/daemon/daemon_client.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"

namespace sweepstake::cli {
namespace {

// Cancels a call as soon as `is_stopped` returns true. It asks on a thread of its own, because
// reading from the stream blocks. A call that has ended is not cancelled, because its status would
// become CANCELLED.
class Canceller {
 public:
  Canceller(grpc::ClientContext& context, const std::function<bool()>& is_stopped)
      : thread_([this, &context, &is_stopped] {
          while (!ended_) {
            if (is_stopped()) return context.TryCancel();
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
          }
        }) {}
  ~Canceller() {
    ended_ = true;
    thread_.join();
  }
  Canceller(const Canceller&) = delete;
  Canceller& operator=(const Canceller&) = delete;

 private:
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace

Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PosteriorsService::NewStub(*channel);
  std::vector<v1::ScenePosterior> scenes;
  v1::ListPosteriorsRequest request;
  request.set_project(project);
  do {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::ListPosteriorsResponse page;
    const Status status = ToStatus(stub->ListPosteriors(&context, request, &page), daemon);
    if (!status.ok()) return status;
    for (v1::ScenePosterior& each : *page.mutable_scenes()) {
      if (scene.empty() || each.scene() == scene) scenes.push_back(std::move(each));
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  const auto stub = v1::PosteriorsService::NewStub(*channel);
  v1::WatchPosteriorsRequest request;
  request.set_project(project);
  request.set_scene(scene);
  grpc::ClientContext context;
  const auto reader = stub->WatchPosteriors(&context, request);
  {
    const Canceller canceller(context, is_stopped);
    v1::WatchPosteriorsResponse event;
    while (reader->Read(&event)) on_event(event);
  }
  const grpc::Status status = reader->Finish();
  if (is_stopped()) return {};
  if (!status.ok()) return ToStatus(status, daemon);
  return {StatusCode::kUnavailable, "the daemon at " + daemon.address + " ended the watch"};
}

}  // namespace sweepstake::cli
