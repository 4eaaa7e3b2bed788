// All topics that are watched over HTTP. Watchers that request the same events with the same token
// share a topic. Used on the server's thread only.
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
  // It borrows `io` and `counters`.
  EventTopics(boost::asio::io_context& io, BeginWatch begin_watch, PostToLoop post_to_loop,
              EventLimits limits, EventCounters& counters);
  ~EventTopics() { context_.inbox->Close(); }

  // Answers with the events of the method. Errors: NOT_FOUND (the method has none),
  // RESOURCE_EXHAUSTED, those of the daemon's subscription.
  void Watch(const std::shared_ptr<Exchange>& exchange, const Method& method,
             const google::protobuf::Message& request, const std::optional<std::string>& token);

 private:
  // Returns what counts the watcher; null if there are too many.
  WatcherShare CountWatcher(const std::string& address);
  // Removes the topic, and destroys it after the function that is running.
  void Remove(const std::string& key);
  void BeatLater();

  TopicContext context_;
  std::map<std::string, size_t> counts_;  // of the watchers, by address
  std::map<std::string, std::shared_ptr<Topic>> topics_;
  std::vector<std::shared_ptr<Topic>> ended_;
  boost::asio::steady_timer beat_timer_;
};

}  // namespace sweepstake::web
