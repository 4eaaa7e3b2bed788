#include "server/web/api/topic_state.h"

#include <map>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::web {
namespace {

constexpr size_t kSessionsPerMessage = 100;

std::string IdOf(const v1::EventStamp& stamp) {
  return absl::StrCat(absl::Hex(stamp.boot(), absl::kZeroPad16), ":", stamp.sequence());
}

// JSON texts by key, whose sizes are counted.
template <typename Key>
class Texts {
 public:
  void Put(Key key, std::string text) {
    bytes_ += text.size();
    std::string& place = texts_[std::move(key)];
    bytes_ -= place.size();
    place = std::move(text);
  }
  void Remove(const Key& key) {
    if (const auto text = texts_.extract(key)) bytes_ -= text.mapped().size();
  }
  size_t bytes() const { return bytes_; }
  const std::map<Key, std::string>& all() const { return texts_; }

 private:
  std::map<Key, std::string> texts_;
  size_t bytes_ = 0;
};

// The part that is the same for all methods.
template <typename Response>
class StateOf : public TopicState {
 public:
  absl::StatusOr<Told> Take(grpc::ByteBuffer bytes) final {
    Response response;
    if (!Parse(std::move(bytes), response))
      return absl::InternalError("an event of the daemon cannot be read");
    Told told{.id = IdOf(response.stamp()), .all_told = response.all_told()};
    if (told.all_told) return told;
    auto json = ToJson(response);
    if (!json.ok()) return json.status();
    told.json = *std::move(json);
    const absl::Status kept = Keep(response, told.json);
    if (!kept.ok()) return kept;
    return told;
  }

 private:
  // Changes the state by a message, whose JSON is given.
  virtual absl::Status Keep(const Response& response, const std::string& json) = 0;
};

// The scenes as they were told last. Decisions are news, and no state.
class PosteriorsState final : public StateOf<v1::WatchPosteriorsResponse> {
 public:
  void Tell(const std::function<void(const std::string&)>& tell) const override {
    for (const auto& [scene, json] : scenes_.all()) tell(json);
  }
  size_t bytes() const override { return scenes_.bytes(); }

 private:
  using Scene = std::tuple<std::string, std::string, std::string, uint32_t>;

  absl::Status Keep(const v1::WatchPosteriorsResponse& response, const std::string& json) override {
    if (!response.has_posterior()) return absl::OkStatus();
    const v1::ScenePosterior& scene = response.posterior();
    scenes_.Put({scene.project(), scene.scene(), scene.machine_class(), scene.reward_version()},
                json);
    return absl::OkStatus();
  }

  Texts<Scene> scenes_;
};

// The sessions that there are, by id.
class SessionsState final : public StateOf<v1::WatchSessionsResponse> {
 public:
  void Tell(const std::function<void(const std::string&)>& tell) const override {
    std::vector<absl::string_view> page;
    const auto end_page = [&] {
      if (!page.empty())
        tell(
            absl::StrCat("{\"sessions\":[", absl::StrJoin(page, ","), "],\"stamp\":", stamp_, "}"));
      page.clear();
    };
    for (const auto& [id, json] : sessions_.all()) {
      page.push_back(json);
      if (page.size() == kSessionsPerMessage) end_page();
    }
    end_page();
  }
  size_t bytes() const override { return sessions_.bytes(); }

 private:
  absl::Status Keep(const v1::WatchSessionsResponse& response, const std::string&) override {
    for (const v1::SessionInfo& session : response.sessions()) {
      auto json = ToJson(session);
      if (!json.ok()) return json.status();
      sessions_.Put(session.session_id(), *std::move(json));
    }
    for (const v1::SessionEnded& ended : response.ended()) sessions_.Remove(ended.session_id());
    auto stamp = ToJson(response.stamp());
    if (stamp.ok()) stamp_ = *std::move(stamp);
    return stamp.status();
  }

  Texts<std::string> sessions_;
  std::string stamp_;  // of the latest message, as JSON
};

// The newest boxes.
class BoxesState final : public StateOf<v1::WatchBoxesResponse> {
 public:
  void Tell(const std::function<void(const std::string&)>& tell) const override {
    if (!newest_.empty()) tell(newest_);
  }
  size_t bytes() const override { return newest_.size(); }

 private:
  absl::Status Keep(const v1::WatchBoxesResponse& /*response*/, const std::string& json) override {
    newest_ = json;
    return absl::OkStatus();
  }

  std::string newest_;  // as JSON
};

// Returns nothing if the request is another method's.
template <typename Request, typename State>
TopicStart StartWith(const google::protobuf::Message& request) {
  const auto* wanted = dynamic_cast<const Request*>(&request);
  if (wanted == nullptr) return {};
  Request marked = *wanted;
  marked.set_mark_all_told(true);
  return {BufferOf(Serialize(marked)), std::make_unique<State>()};
}

}  // namespace

TopicStart StartOfTopic(const google::protobuf::Message& request) {
  TopicStart topic = StartWith<v1::WatchPosteriorsRequest, PosteriorsState>(request);
  if (topic.state) return topic;
  topic = StartWith<v1::WatchSessionsRequest, SessionsState>(request);
  if (topic.state) return topic;
  return StartWith<v1::WatchBoxesRequest, BoxesState>(request);
}

}  // namespace sweepstake::web
