// Encodes the parts of events as messages of sweepstake.v1. Thread-safe.
#pragma once

#include <string>

#include "server/events/event.h"
#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {

class EventEncoder final : public events::Encoder {
 public:
  std::string Scene(const priors::SceneEvidence& scene) const override {
    v1::WatchPosteriorsResponse response;
    ToProto(scene, *response.mutable_posterior());
    return response.SerializeAsString();
  }
  std::string Activity(const sessions::SceneActivity& activity) const override {
    v1::WatchPosteriorsResponse response;
    ToProto(activity, *response.mutable_posterior());
    return response.SerializeAsString();
  }
  std::string Decision(const sessions::SessionDecision& decision) const override {
    v1::WatchPosteriorsResponse response;
    ToProto(decision, *response.add_decisions());
    return response.SerializeAsString();
  }
  std::string Session(const sessions::SessionView& session) const override {
    v1::WatchSessionsResponse response;
    ToProto(session, *response.add_sessions());
    return response.SerializeAsString();
  }
  std::string SessionEnd(const std::string& session_id, sessions::SessionEnd end) const override {
    v1::WatchSessionsResponse response;
    v1::SessionEnded& ended = *response.add_ended();
    ended.set_session_id(session_id);
    ended.set_end(static_cast<v1::SessionEnd>(end));
    return response.SerializeAsString();
  }
  std::string Boxes(const std::string& view) const override {
    v1::WatchBoxesResponse response;
    response.mutable_view()->ParseFromString(view);
    return response.SerializeAsString();
  }
  std::string Stamp(events::Kind kind, const events::EventStamp& stamp) const override {
    if (kind == events::Kind::kPosteriors) return Stamp<v1::WatchPosteriorsResponse>(stamp);
    if (kind == events::Kind::kSessions) return Stamp<v1::WatchSessionsResponse>(stamp);
    return Stamp<v1::WatchBoxesResponse>(stamp);
  }

 private:
  template <typename Response>
  static std::string Stamp(const events::EventStamp& stamp) {
    Response response;
    ToProto(stamp, *response.mutable_stamp());
    return response.SerializeAsString();
  }
};

}  // namespace sweepstake::rpc
