// All topics that are watched over HTTP. A topic is one subscription to the daemon's events
// (topic.h). Clients that request the same events with the same token share a topic. Used on the
// server's thread only.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/web/api/topic.h"

namespace sweepstake::web {

class EventTopics {
 public:
  // `io` and `counters` must outlive this object.
  EventTopics(boost::asio::io_context& io, BeginWatch begin_watch, PostToLoop post_to_loop,
              EventLimits limits, EventCounters& counters);
  ~EventTopics() { context_.inbox->Close(); }

  // Answers with the events of the method. Errors: NOT_FOUND (the method has none),
  // RESOURCE_EXHAUSTED (too many watchers), and those of the subscription.
  void Watch(const std::shared_ptr<Exchange>& exchange, const Method& method,
             const google::protobuf::Message& request, const std::optional<std::string>& token);

 private:
  // Counts a watcher from this address until the result is destroyed. Returns null if there are too
  // many watchers.
  WatcherShare CountWatcher(const std::string& address);
  // Removes the topic. Destroys it later, because one of its functions calls Remove.
  void Remove(const std::string& key);
  void BeatLater();

  TopicContext context_;
  std::map<std::string, size_t> counts_;  // number of watchers by address
  std::map<std::string, std::shared_ptr<Topic>> topics_;
  std::vector<std::shared_ptr<Topic>> ended_;
  boost::asio::steady_timer beat_timer_;
};

}  // namespace sweepstake::web
