// The stream of one who watches sessions: first the matching ones as they are, page by page, then
// those that change.
//
// One that has read everything by the next tick gets its changes as they were encoded for all
// watchers of the same filter. For one that reads more slowly only the ids of the changed sessions
// are kept, and each is told once, as it is by then: its memory is bounded by the number of
// sessions.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/rpc/services/watcher.h"
#include "server/sessions/box_views.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::rpc {

class SessionsService;

// What has changed by one tick for all watchers of one filter.
struct SessionTick {
  watch::SessionChanges changes;
  std::vector<grpc::ByteBuffer> messages;
};

class SessionWatcher final : public Watcher {
 public:
  SessionWatcher(ServiceContext& context, SessionsService& service,
                 grpc::CallbackServerContext& call, auth::Principal caller)
      : Watcher(context, call, std::move(caller)), service_(service) {}

  void OnTick(std::shared_ptr<const SessionTick> tick);

 private:
  absl::Status Join() override;
  void Leave() override;
  std::optional<grpc::ByteBuffer> TakeNext() override;
  void Forget() override;

  // Returns the next page of the sessions that there are; absent after the last one.
  std::optional<grpc::ByteBuffer> TakePage();

  SessionsService& service_;
  std::optional<std::string> listed_until_ = "";  // the next page begins after it
  std::shared_ptr<const SessionTick> tick_;       // null if it was read
  size_t next_message_ = 0;                       // of tick_
  watch::SessionChanges changes_;                 // after tick_
};

// The stream of one who looks at the boxes of a session's objects. One that reads slowly gets the
// newest view, and no other is kept.
class BoxWatcher final : public Watcher, public sessions::BoxViewListener {
 public:
  BoxWatcher(ServiceContext& context, SessionsService& service, grpc::CallbackServerContext& call,
             auth::Principal caller)
      : Watcher(context, call, std::move(caller)), service_(service) {}

  // Any project that the client's token is for.
  priors::SceneFilter WantedBy(const v1::WatchBoxesRequest& request) {
    session_id_ = request.session_id();
    return {};
  }
  void OnView(const sessions::BoxView& view) override;
  void OnEnd(const absl::Status& status) override { Close(status); }

 private:
  absl::Status Join() override;
  void Leave() override;
  std::optional<grpc::ByteBuffer> TakeNext() override;
  void Forget() override { newest_.reset(); }

  SessionsService& service_;
  std::string session_id_;
  std::weak_ptr<sessions::GameSession> session_;  // of which it is a viewer
  std::optional<grpc::ByteBuffer> newest_;
};

}  // namespace sweepstake::rpc
