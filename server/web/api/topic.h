// One topic: a stream of the daemon's events and all who watch it by HTTP.
//
// The topic has one stream of the daemon's service, makes JSON of each message once, and hands the
// same text to every watcher, all messages of a moment at a time. It keeps the state that the
// messages say together: who comes later, or reads so slowly that it misses texts, gets that. Who
// lost its connection gets what it missed, as far as the latest messages are kept.
//
// Used on the server's thread only.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/web/api/topic_state.h"
#include "server/web/api/upstream.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct EventLimits {
  // The maximum number of watchers; one more is RESOURCE_EXHAUSTED. An address that is not the
  // daemon's own machine may have half of them.
  size_t max_watchers = 1'536;
  // The maximum bytes of the states of all topics; the topic that would exceed it ends with
  // RESOURCE_EXHAUSTED.
  size_t max_state_bytes = 128 * 1024 * 1024;
  // The bytes of a topic's latest messages that are kept for who lost its connection.
  size_t kept_bytes = 256 * 1024;
  // The maximum texts that wait for a watcher; beyond it, it gets the state in their place.
  size_t max_waiting = 4;
  // Messages that come within this time after the first one go out as one text.
  std::chrono::milliseconds moment{50};
  // A topic that nobody watches stays for this time, so that a lost watcher finds what it missed.
  std::chrono::milliseconds idle_patience{15'000};
  // A watcher that has nothing to read gets a comment in this interval.
  std::chrono::milliseconds heartbeat{15'000};
};

// Written on the server's thread, read by any.
struct EventCounters {
  std::atomic<uint64_t> open_watcher_count{0};
  std::atomic<uint64_t> open_topic_count{0};
  std::atomic<uint64_t> encoded_count{0};  // messages of which JSON was made
  std::atomic<uint64_t> skip_count{0};     // times that a watcher read too slowly
};

// What all topics have in common.
struct TopicContext {
  boost::asio::io_context& io;
  Upstream& upstream;
  const EventLimits limits;
  EventCounters& counters;
  size_t state_bytes = 0;  // of all topics
};

// Text that any number of watchers share.
using SharedText = std::shared_ptr<const std::string>;
// What a watcher is counted by as long as it lives.
using WatcherShare = std::shared_ptr<void>;

class Topic : public std::enable_shared_from_this<Topic> {
 public:
  // `on_end` is told when the daemon's stream has ended, or nobody has watched for idle_patience:
  // nobody may join then. It must not destroy this object before it returns.
  Topic(TopicContext& context, std::unique_ptr<TopicState> state, std::function<void()> on_end);
  ~Topic();
  Topic(const Topic&) = delete;
  Topic& operator=(const Topic&) = delete;

  // Begins the daemon's stream. Called once.
  void Open(UpstreamRequest request);
  // Answers with events: those after the request's Last-Event-ID if they are kept, else the state
  // first. If the daemon refuses the stream, with that error.
  void Join(std::shared_ptr<Exchange> exchange, WatcherShare share);
  void Beat();

 private:
  class Watcher;
  struct KeptMessage {
    std::string id;
    std::string text;
  };

  bool idle() const { return watchers_.empty() && waiting_.empty(); }
  void OnMessage(grpc::ByteBuffer bytes);
  void OnEnd(const absl::Status& status);
  void CountState();
  void Begin(Exchange& exchange, WatcherShare share);
  // Returns what came after the message; null if that is not known any more.
  SharedText MissedSince(std::string_view id) const;
  SharedText Snapshot();
  void Add(const std::string& text);
  void Keep(const std::string& id, const std::string& text);
  // Hands all that was added to the watchers.
  void Flush();
  void Leave(Watcher& watcher);

  TopicContext& context_;
  const std::unique_ptr<TopicState> state_;
  const std::function<void()> on_end_;
  std::unique_ptr<Upstream::Stream> stream_;
  std::vector<std::pair<std::shared_ptr<Exchange>, WatcherShare>>
      waiting_;  // for the first message
  std::set<Watcher*> watchers_;
  bool begun_ = false;     // there was a message
  bool all_told_ = false;  // the state is complete
  std::string last_id_;    // of the latest message
  std::string added_;      // not handed out yet
  SharedText snapshot_;    // null if the state has changed since
  std::deque<KeptMessage> kept_;
  size_t kept_bytes_ = 0;
  size_t state_bytes_ = 0;  // as counted
  boost::asio::steady_timer flush_timer_;
  boost::asio::steady_timer idle_timer_;
};

}  // namespace sweepstake::web
