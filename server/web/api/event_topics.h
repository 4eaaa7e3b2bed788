// All topics that somebody watches by HTTP. Who asks for the same events with the same token shares
// a topic. Used on the server's thread only.
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
  // It borrows all but the limits.
  EventTopics(boost::asio::io_context& io, Upstream& upstream, EventLimits limits,
              EventCounters& counters);

  // Answers with the events that the request's method has for it. Errors: NOT_FOUND (the method has
  // none), RESOURCE_EXHAUSTED, those of the daemon's stream.
  void Watch(const std::shared_ptr<Exchange>& exchange, const std::string& path,
             const google::protobuf::Message& request, std::optional<std::string> token);

 private:
  // Returns what the watcher is counted by; null if there are too many.
  WatcherShare CountWatcher(const std::string& address);
  std::shared_ptr<Topic> Open(const std::string& key, std::unique_ptr<TopicState> state,
                              UpstreamRequest request);
  // Forgets the topic, and destroys it once what runs is done.
  void Remove(const std::string& key);
  void BeatLater();

  TopicContext context_;
  std::map<std::string, size_t> counts_;  // of the watchers, by address
  std::map<std::string, std::shared_ptr<Topic>> topics_;
  std::vector<std::shared_ptr<Topic>> ended_;
  boost::asio::steady_timer beat_timer_;
};

}  // namespace sweepstake::web
