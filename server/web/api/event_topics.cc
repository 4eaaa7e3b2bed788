#include "server/web/api/event_topics.h"

#include <boost/asio/post.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/peer_address.h"
#include "server/web/error_page.h"

namespace sweepstake::web {

EventTopics::EventTopics(boost::asio::io_context& io, BeginWatch begin_watch,
                         PostToLoop post_to_loop, EventLimits limits, EventCounters& counters)
    : context_{io,
               std::move(begin_watch),
               std::move(post_to_loop),
               std::make_shared<Inbox>(io),
               limits,
               counters},
      beat_timer_(io) {
  BeatLater();
}

void EventTopics::Watch(const std::shared_ptr<Exchange>& exchange, const Method& method,
                        const google::protobuf::Message& request,
                        const std::optional<std::string>& token) {
  const std::string& peer = exchange->request().peer;
  WatcherShare share = CountWatcher(net::AddressOf(peer));
  if (!share) {
    return exchange->Answer(ErrorPage(absl::ResourceExhaustedError(
        "the daemon, or your address, has the maximum number of watchers; try again later")));
  }
  // A line break separates the parts. Type names and tokens contain no line breaks.
  const std::string key =
      absl::StrCat(request.GetTypeName(), "\n", token.value_or(""), "\n", Serialize(request));
  std::shared_ptr<Topic>& topic = topics_[key];
  if (topic == nullptr) {
    topic = std::make_shared<Topic>(context_, *method.response, [this, key] { Remove(key); });
    if (!topic->Open(request, peer, token)) {
      topics_.erase(key);
      return exchange->Answer(ErrorPage(absl::NotFoundError("this method has no events")));
    }
  }
  topic->Join(exchange, std::move(share));
}

void EventTopics::Remove(const std::string& key) {
  auto topic = topics_.extract(key);
  if (topic.empty()) return;
  ended_.push_back(std::move(topic.mapped()));
  boost::asio::post(context_.io, [this] { ended_.clear(); });
}

WatcherShare EventTopics::CountWatcher(const std::string& address) {
  const size_t max = context_.limits.max_watchers;
  auto& open_count = context_.counters.open_watcher_count;
  const auto own = counts_.find(address);
  const size_t own_count = own == counts_.end() ? 0 : own->second;
  if (open_count >= max || (own_count >= (max + 1) / 2 && !net::IsLoopbackAddress(address)))
    return nullptr;
  ++open_count;
  ++counts_[address];
  return WatcherShare(this, [address](void* self) {
    auto& topics = *static_cast<EventTopics*>(self);
    --topics.context_.counters.open_watcher_count;
    if (--topics.counts_.at(address) == 0) topics.counts_.erase(address);
  });
}

void EventTopics::BeatLater() {
  beat_timer_.expires_after(context_.limits.heartbeat);
  beat_timer_.async_wait([this](boost::system::error_code cancelled) {
    if (cancelled) return;
    for (const auto& [key, topic] : topics_) topic->Beat();
    BeatLater();
  });
}

}  // namespace sweepstake::web
