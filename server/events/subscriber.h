// One watcher of the bus, and the sink that its events go to. Used on the decision loop only.
//
// A subscriber receives the current state of what it watches and then the changes, as fast as its
// sink takes them. A slow one receives each changed scene or session once, in its latest state, and
// misses decisions. Its memory is bounded by kQueueBytes and one pointer for each scene or session.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/events/event.h"

namespace sweepstake::events {

class EventBus;
class Subscriber;
struct Channel;

// Where events go: a gRPC call, or the connections of browsers.
class Sink {
 public:
  virtual ~Sink() = default;

  // The subscription has begun. It ends when the subscriber is destroyed.
  virtual void Begin(std::unique_ptr<Subscriber> subscriber) = 0;
  // There may be something to take. It must not end the subscription.
  virtual void Wake() = 0;
  // The subscription has ended, or was refused. Nothing follows; the subscriber may be destroyed.
  virtual void OnEnd(const absl::Status& status) = 0;
};

// What to watch, and for whom.
struct Wish {
  Kind kind = Kind::kPosteriors;
  priors::SceneFilter filter = {};           // must match only what the caller may see
  std::string session_id = {};               // for boxes
  bool mark = false;                         // send a mark after the initial state
  bool snapshots = false;                    // the sink takes the initial state with TakeSnapshot
  std::function<absl::Status()> check = {};  // returns whether the caller may still watch
  std::function<void(const absl::Status&)> on_end = {};  // called before Sink::OnEnd
  std::shared_ptr<void> share = {};  // counts the watcher while it is subscribed
};

class Subscriber {
 public:
  // Decisions that wait are dropped beyond this size. The latest state always waits.
  static constexpr size_t kQueueBytes = 256 * 1024;

  Subscriber(EventBus& bus, Wish wish, Sink& sink);
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Takes up to `max` events that may be joined to one message, which has each scene or session
  // once. Empty: nothing is there now, and Sink::Wake follows.
  std::vector<EventPtr> Take(size_t max);

  // The whole state at one moment. Events that Take returns later are newer.
  struct Snapshot {
    EventStamp stamp;
    std::vector<EventPtr> events;
  };
  // Returns the state; absent while it is incomplete, and Sink::Wake follows. REQUIRES:
  // Wish::snapshots, and Take has nothing more.
  std::optional<Snapshot> TakeSnapshot();

 private:
  friend class EventBus;

  // A decision or, without an event, the place of a key in latest_.
  struct Place {
    std::string key;
    EventPtr decisions;
  };

  // Called for a new state of a scene or session.
  void Put(const std::string& key, const EventPtr& event);
  void PutDecisions(const EventPtr& event);
  // The state has been cleared, and is loaded again.
  void Restart();
  EventPtr NextOfState();
  EventPtr NextOfQueue();

  EventBus& bus_;
  Wish wish_;
  Sink& sink_;
  std::shared_ptr<Channel> channel_;  // null unless subscribed
  // The initial state has been taken up to this key; absent: all of it.
  std::optional<std::string> cursor_ = "";
  std::deque<Place> queue_;  // in the order of time
  size_t decision_bytes_ = 0;
  std::map<std::string, EventPtr> latest_;  // of the keys in queue_
};

}  // namespace sweepstake::events
