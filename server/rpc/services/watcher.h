// The stream of one who watches, whatever it shows, and those that are open.
//
// A watcher is told only as fast as it reads: the next message is asked for when the one before is
// written, so that each kind decides what a client that reads slowly misses. One that does not read
// at all is disconnected. It is used on the decision loop; gRPC's callbacks run elsewhere and only
// post to the loop.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::rpc {

// What it writes are encoded messages, since many watchers are told the same. It owns itself from
// Start until gRPC is done with it.
class Watcher : public grpc::ServerWriteReactor<grpc::ByteBuffer>,
                public StallingCall,
                public std::enable_shared_from_this<Watcher> {
 public:
  // Begins to serve the call. `bytes` are its request, which says what is wanted and whether to
  // mark that all has been told.
  template <typename Request, typename Kind>
  static Watcher* Start(const std::shared_ptr<Kind>& watcher, grpc::ByteBuffer bytes) {
    Watcher* const raw = watcher.get();
    raw->self_ = watcher;
    raw->context_.loop.Post([raw, kind = watcher.get(), bytes = std::move(bytes)]() mutable {
      Request request;
      if (!Parse(bytes, request)) {
        return raw->Close(
            Refused(v1::ERROR_REASON_MALFORMED_MESSAGE, "the request does not parse"));
      }
      raw->mark_wanted_ = request.mark_all_told();
      raw->Begin(kind->WantedBy(request));
    });
    return raw;
  }

  // Returns what the client asks for.
  template <typename Request>
  static priors::SceneFilter WantedBy(const Request& request) {
    return {request.project(), request.scene()};
  }
  // Of what the client asked for, only what its token is for.
  const priors::SceneFilter& filter() const { return filter_; }
  // Closes the stream if the caller's token is not valid any more.
  void EndIfRefused();
  // Ends the stream. The log tells of a refusal.
  void Close(const absl::Status& status);
  int64_t waiting_since_ns() const override {
    return writing_ ? write_start_ns_ : sessions::Clock::kNever;
  }
  void OnStalled() override;

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 protected:
  Watcher(ServiceContext& context, grpc::CallbackServerContext& call, auth::Principal caller)
      : context_(context), call_(call), caller_(std::move(caller)) {}

  // Enters and leaves the group of its kind. Leave does nothing if it is not in the group.
  virtual absl::Status Join() = 0;
  virtual void Leave() = 0;
  // Returns the next message; absent if there is nothing to say until WriteNext is called again.
  virtual std::optional<grpc::ByteBuffer> TakeNext() = 0;
  // Frees what waits: the stream ends.
  virtual void Forget() = 0;

  // Called when there may be something to say.
  void WriteNext();
  // Returns whether the client is to be told now that all has been told. Once.
  bool TakeMark() { return std::exchange(mark_wanted_, false); }
  bool closed() const { return end_.has_value(); }
  ServiceContext& context() { return context_; }

 private:
  void Begin(priors::SceneFilter wanted);
  absl::Status TakeShare();
  void OnWritten(bool ok);

  ServiceContext& context_;
  grpc::CallbackServerContext& call_;
  const auth::Principal caller_;
  std::shared_ptr<Watcher> self_;  // keeps this object alive until OnDone
  priors::SceneFilter filter_;
  bool mark_wanted_ = false;
  AccessControl::Share share_;  // while it is in its group
  grpc::ByteBuffer write_bytes_;
  bool writing_ = false;
  int64_t write_start_ns_ = 0;
  std::optional<absl::Status> end_;
  bool finished_ = false;
};

// The open watchers of one kind. All kinds share RpcOptions::max_watchers.
template <typename Kind>
class WatcherGroup {
 public:
  explicit WatcherGroup(ServiceContext& context) : context_(context) {}

  // Errors: RESOURCE_EXHAUSTED (there are RpcOptions::max_watchers already), UNAVAILABLE
  // (draining).
  absl::Status Add(Kind& watcher) {
    if (draining_) return Draining();
    if (context_.counters.open_watcher_count >= context_.options.max_watchers) {
      return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                     "this daemon has as many watchers as it may; try again later");
    }
    all_.insert(&watcher);
    of_scene_.clear();
    ++context_.counters.open_watcher_count;
    return absl::OkStatus();
  }
  void Remove(Kind& watcher) {
    of_scene_.clear();
    context_.counters.open_watcher_count -= all_.erase(&watcher);
  }

  bool empty() const { return all_.empty(); }
  // Returns those that watch the scene. They are looked for once, not at each of its decisions.
  const std::vector<Kind*>& Of(const priors::SceneKey& scene) {
    if (of_scene_.size() > kMaxScenes) of_scene_.clear();
    const auto [found, unknown] = of_scene_.try_emplace(scene);
    if (!unknown) return found->second;
    for (Kind* watcher : all_) {
      if (watcher->filter().Matches(scene.project, scene.scene)) found->second.push_back(watcher);
    }
    return found->second;
  }
  // Calls `tell` with each watcher. One that ends may remove itself meanwhile.
  template <typename Tell>
  void ForEach(Tell tell) {
    for (auto next = all_.begin(); next != all_.end();) tell(**next++);
  }

  void Drain() {
    draining_ = true;
    ForEach([](Kind& watcher) { watcher.Close(Draining()); });
  }
  // Ends the streams of callers whose tokens are not valid any more.
  void EndRefused() {
    ForEach([](Kind& watcher) { watcher.EndIfRefused(); });
  }

 private:
  static constexpr size_t kMaxScenes = 10'000;  // with an answer in of_scene_

  static absl::Status Draining() {
    return Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; watch again later");
  }

  ServiceContext& context_;
  std::set<Kind*> all_;
  std::map<priors::SceneKey, std::vector<Kind*>> of_scene_;
  bool draining_ = false;
};

}  // namespace sweepstake::rpc
