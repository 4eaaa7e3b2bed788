// One topic: a subscription to the daemon's events, and all who watch it over HTTP.
//
// Every watcher of the topic receives the same text; messages that come within a moment are joined
// to one text. The JSON of an event is made once, whatever the number of topics. A watcher that is
// new, or reads so slowly that it misses texts, receives a snapshot: the whole state as the bus has
// it. A watcher that comes back receives the messages that it missed, while they are kept.
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
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/events/subscriber.h"
#include "server/web/api/inbox.h"
#include "server/web/api/methods.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct EventLimits {
  // The maximum number of watchers; one more is RESOURCE_EXHAUSTED. An address that is not on the
  // daemon's own machine may have half of them.
  size_t max_watchers = 1'536;
  // The maximum size of a snapshot; a topic that would exceed it ends with RESOURCE_EXHAUSTED.
  size_t max_snapshot_bytes = 128 * 1024 * 1024;
  // The size of a topic's latest messages that are kept for watchers that lost their connection.
  size_t kept_bytes = 256 * 1024;
  // The maximum number of texts that wait for a watcher; beyond it, they are replaced by a
  // snapshot.
  size_t max_waiting = 4;
  // Messages that come within this time after the first one are sent as one text.
  std::chrono::milliseconds moment{50};
  // A topic without watchers stays for this time, so that a watcher that comes back finds the
  // messages that it missed.
  std::chrono::milliseconds idle_patience{15'000};
  // A watcher that has nothing to read receives a comment in this interval.
  std::chrono::milliseconds heartbeat{15'000};
};

// Written on the server's thread, read by any.
struct EventCounters {
  std::atomic<uint64_t> open_watcher_count{0};
  std::atomic<uint64_t> open_topic_count{0};
  std::atomic<uint64_t> encoded_count{0};  // messages of which JSON was made
  std::atomic<uint64_t> skip_count{0};     // times that a watcher read too slowly
};

// Begins to watch as the message asks, for a client in gRPC's format with or without a token.
// Returns false if the message is not a request of a Watch method.
using BeginWatch = std::function<bool(
    const google::protobuf::Message& request, const std::string& peer,
    const std::optional<std::string>& token, std::shared_ptr<events::Sink> sink)>;

// Runs a task on the decision loop.
using PostToLoop = std::function<void(std::function<void()>)>;

// What all topics have in common.
struct TopicContext {
  boost::asio::io_context& io;
  const BeginWatch begin_watch;
  const PostToLoop post_to_loop;
  const std::shared_ptr<Inbox> inbox;
  const EventLimits limits;
  EventCounters& counters;
};

// Text that any number of watchers share.
using SharedText = std::shared_ptr<const std::string>;
// Counts a watcher as long as it lives.
using WatcherShare = std::shared_ptr<void>;

class Topic : public std::enable_shared_from_this<Topic> {
 public:
  // `message` is an empty message of the topic. `on_end` is called when the subscription has ended,
  // or there were no watchers for idle_patience: then nobody may join. It must not destroy this
  // object before it returns.
  Topic(TopicContext& context, const google::protobuf::Message& message,
        std::function<void()> on_end);
  ~Topic();
  Topic(const Topic&) = delete;
  Topic& operator=(const Topic&) = delete;

  // Begins the subscription. Returns false if the request is not one of a Watch method. Called
  // once.
  bool Open(const google::protobuf::Message& request, const std::string& caller,
            const std::optional<std::string>& token);
  // Answers with events: those after the request's Last-Event-ID if they are kept, else a snapshot
  // first. If the daemon refuses the subscription, answers with that error.
  void Join(std::shared_ptr<Exchange> exchange, WatcherShare share);
  void Beat();

 private:
  class Feed;
  class Watcher;
  // The events since the previous batch and, if it was requested, the state after them.
  struct Batch {
    std::vector<events::EventPtr> events;
    std::optional<events::Subscriber::Snapshot> snapshot;
  };
  struct KeptMessage {
    std::string id;
    std::string text;
  };
  // A snapshot whose text is being made, some events at a time, so that other requests are answered
  // meanwhile.
  struct Making {
    events::Subscriber::Snapshot snapshot = {};
    size_t next = 0;  // the place in its events
    std::string text = {};
    std::string later = {};  // what was handed to the watchers since
  };

  bool idle() const { return watchers_.empty() && waiting_.empty(); }
  void OnBatch(const Batch& batch);
  void OnEnd(const absl::Status& status);
  void Close();
  const std::string& JsonOf(const events::Event& event);
  void Begin(Exchange& exchange, WatcherShare share, const std::vector<SharedText>& texts);
  // Returns the messages after this one; null if that is not known any more.
  SharedText MissedSince(std::string_view id) const;
  void WantSnapshot();
  void MakeSnapshot();
  void HandOutSnapshot();
  void Add(const std::string& text);
  void Keep(const std::string& id, const std::string& text);
  // Hands everything that was added to the watchers.
  void Flush();
  void Leave(Watcher& watcher);

  TopicContext& context_;
  const google::protobuf::Message& message_;
  const std::function<void()> on_end_;
  const std::shared_ptr<Feed> feed_;
  // These wait for a snapshot.
  std::vector<std::pair<std::shared_ptr<Exchange>, WatcherShare>> waiting_;
  std::set<Watcher*> watchers_;
  std::string added_;    // not handed out yet
  SharedText snapshot_;  // null if the state has changed since
  bool snapshot_wanted_ = false;
  std::optional<Making> making_;
  std::deque<KeptMessage> kept_;
  size_t kept_bytes_ = 0;
  boost::asio::steady_timer flush_timer_;
  boost::asio::steady_timer idle_timer_;
};

}  // namespace sweepstake::web
