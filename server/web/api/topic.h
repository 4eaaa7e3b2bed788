// A topic: one subscription to the daemon's events, and all HTTP clients that watch it (watchers).
//
// - All watchers of a topic receive the same texts. Messages that arrive within
//   `EventLimits::moment` are joined to one text.
// - The JSON of an event is made once, even if several topics send it.
// - A new watcher receives a snapshot: the whole current state. So does a watcher that reads so
//   slowly that it misses texts.
// - All watchers receive a snapshot if the bus replaces the whole state, for instance after a
//   revocation.
// - A watcher that reconnects receives the messages that it missed, if they are still kept.
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
  // The maximum number of watchers; further ones get RESOURCE_EXHAUSTED. One remote address can
  // have at most half of them.
  size_t max_watchers = 1'536;
  // The maximum size of a snapshot; a topic that would exceed it ends with RESOURCE_EXHAUSTED.
  size_t max_snapshot_bytes = 128 * 1024 * 1024;
  // Maximum bytes of a topic's latest messages, which are kept for watchers that reconnect.
  size_t kept_bytes = 256 * 1024;
  // The maximum number of texts that wait for a watcher; beyond it, they are replaced by a
  // snapshot.
  size_t max_waiting = 4;
  // Messages that come within this time after the first one are sent as one text.
  std::chrono::milliseconds moment{50};
  // A topic without watchers is kept for this time, so that a watcher that reconnects gets the
  // messages that it missed.
  std::chrono::milliseconds idle_patience{15'000};
  // A watcher that has nothing to read receives a comment in this interval.
  std::chrono::milliseconds heartbeat{15'000};
};

// Counters for metrics. Written on the server's thread, read by any thread.
struct EventCounters {
  std::atomic<uint64_t> open_watcher_count{0};
  std::atomic<uint64_t> open_topic_count{0};
  std::atomic<uint64_t> encoded_count{0};  // events that were converted to JSON
  std::atomic<uint64_t> skip_count{0};     // times that a watcher read too slowly
};

// Begins the subscription that `request` describes, and passes its events to `sink`. `peer` is the
// client's address in gRPC's format. Returns false if `request` does not belong to a Watch method.
using BeginWatch = std::function<bool(
    const google::protobuf::Message& request, const std::string& peer,
    const std::optional<std::string>& token, std::shared_ptr<events::Sink> sink)>;

// Runs a task on the decision loop's thread.
using PostToLoop = std::function<void(std::function<void()>)>;

// Objects and functions that all topics use.
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
// Owned by each watcher. EventTopics counts the watcher until the last copy is destroyed.
using WatcherShare = std::shared_ptr<void>;

class Topic : public std::enable_shared_from_this<Topic> {
 public:
  // `message` is an empty message of the type of the topic's events. `on_end` is called when the
  // subscription has ended, or after idle_patience without watchers. Join must not be called after
  // that. `on_end` must not destroy this object before it returns.
  Topic(TopicContext& context, const google::protobuf::Message& message,
        std::function<void()> on_end);
  ~Topic();
  Topic(const Topic&) = delete;
  Topic& operator=(const Topic&) = delete;

  // Begins the subscription. Returns false if the request does not belong to a Watch method. Called
  // once.
  bool Open(const google::protobuf::Message& request, const std::string& caller,
            const std::optional<std::string>& token);
  // Adds the client as a watcher. Answers with the events after the request's Last-Event-ID if they
  // are kept, otherwise with a snapshot and the events after it. If the daemon refuses the
  // subscription, answers with that error.
  void Join(std::shared_ptr<Exchange> exchange, WatcherShare share);
  void Beat();

 private:
  class Feed;
  class Watcher;
  // The events since the previous batch and, if one was requested, a snapshot of the state after
  // them.
  struct Batch {
    std::vector<events::EventPtr> events;
    std::optional<events::Subscriber::Snapshot> snapshot;
  };
  struct KeptMessage {
    std::string id;
    std::string text;
  };
  // A snapshot that is being converted to text. Only some events are converted at a time, so that
  // other requests are answered in between.
  struct Making {
    events::Subscriber::Snapshot snapshot = {};
    size_t next = 0;  // index of the next event to convert
    std::string text = {};
    std::string later = {};  // texts sent to watchers after the snapshot was taken
  };

  bool idle() const { return watchers_.empty() && waiting_.empty(); }
  void OnBatch(const Batch& batch);
  void OnEnd(const absl::Status& status);
  void Close();
  const std::string& JsonOf(const events::Event& event);
  void Begin(Exchange& exchange, WatcherShare share, const std::vector<SharedText>& texts);
  // Returns the messages after the message `id`; null if that message is not kept any more.
  SharedText MissedSince(std::string_view id) const;
  void WantSnapshot();
  // Drops the old state, because a snapshot that replaces it is about to be made. All watchers will
  // receive that snapshot.
  void DropState();
  void MakeSnapshot();
  void HandOutSnapshot();
  void Add(const std::string& text);
  void Keep(const std::string& id, const std::string& text);
  // Sends the text in added_ to all watchers.
  void Flush();
  void Leave(Watcher& watcher);

  TopicContext& context_;
  const google::protobuf::Message& message_;
  const std::function<void()> on_end_;
  const std::shared_ptr<Feed> feed_;
  // New watchers, which wait for a snapshot.
  std::vector<std::pair<std::shared_ptr<Exchange>, WatcherShare>> waiting_;
  std::set<Watcher*> watchers_;
  std::string added_;    // text that is not sent yet
  SharedText snapshot_;  // text of the latest snapshot; null if the state has changed since
  bool snapshot_wanted_ = false;
  std::optional<Making> making_;
  std::deque<KeptMessage> kept_;
  size_t kept_bytes_ = 0;
  boost::asio::steady_timer flush_timer_;
  boost::asio::steady_timer idle_timer_;
};

}  // namespace sweepstake::web
