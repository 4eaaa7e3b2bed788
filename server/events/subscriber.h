// One watcher of the event bus, and the interface of the sink that receives its events. Used on the
// decision loop only.
//
// A subscriber first receives the current state of every scene or session that it watches, and then
// the changes, as fast as its sink takes them. If the sink is slow, it receives each changed scene
// or session once, in its latest state, and decisions above kQueueBytes are dropped. Memory:
// kQueueBytes, plus one entry for each changed scene or session.
//
// When evidence was imported, promoted or revoked, the subscriber receives the whole state again.
// After it come the earlier scenes that have no evidence any more, each as a scene without arms.
// Sinks with Wish::snapshots take a new snapshot instead.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/events/event.h"

namespace sweepstake::events {

class EventBus;
class Subscriber;
struct Channel;

// The receiver of events: a gRPC call, or the connections of browsers.
class Sink {
 public:
  virtual ~Sink() = default;

  // The subscription has begun. It ends when the subscriber is destroyed.
  virtual void Begin(std::unique_ptr<Subscriber> subscriber) = 0;
  // Called when Subscriber::Take may return events. The sink must not end the subscription in this
  // call.
  virtual void Wake() = 0;
  // The subscription has ended, or was refused. No other call follows. The sink may destroy its own
  // subscriber, but no other one, because the bus may be ending several subscribers one by one.
  virtual void OnEnd(const absl::Status& status) = 0;
};

// The scenes, sessions or boxes that a watcher wants to see, and the checks of its permission.
struct Wish {
  Kind kind = Kind::kPosteriors;
  priors::SceneFilter filter = {};           // must match only scenes that the caller may see
  std::string session_id = {};               // for boxes
  bool snapshots = false;                    // the sink takes the initial state with TakeSnapshot
  std::function<absl::Status()> check = {};  // returns whether the caller may still watch
  std::function<void(const absl::Status&)> on_end = {};  // called before Sink::OnEnd
  // released when the subscription ends, which uncounts the watcher
  std::shared_ptr<void> share = {};
};

class Subscriber {
 public:
  // Maximum size of the queued decisions. Above it all queued decisions are dropped. Queued states
  // of scenes and sessions are never dropped.
  static constexpr size_t kQueueBytes = 256 * 1024;

  Subscriber(EventBus& bus, Wish wish, Sink& sink);
  ~Subscriber();
  Subscriber(const Subscriber&) = delete;
  Subscriber& operator=(const Subscriber&) = delete;

  // Takes up to `max` events from the queue. They may be joined to one message, because each scene
  // or session occurs at most once. If the result is empty, Sink::Wake is called when there are
  // more events.
  std::vector<EventPtr> Take(size_t max);

  // The events of all watched scenes or sessions at one moment. Events that Take returns later are
  // newer.
  struct Snapshot {
    EventStamp stamp;
    std::vector<EventPtr> events;
    bool replaces_all = false;  // all earlier snapshots and events are void: see needs_snapshot
  };
  // Returns a snapshot. It is absent while the state is still being loaded; then Sink::Wake is
  // called later. REQUIRES: Wish::snapshots is set, and Take has returned all events.
  std::optional<Snapshot> TakeSnapshot();
  // Returns whether the state was replaced since the last snapshot, because evidence was imported,
  // promoted or revoked. Scenes may be missing in the new state. Their removal causes no event, so
  // the sink must take a snapshot. Always false unless Wish::snapshots is set.
  bool needs_snapshot() const { return needs_snapshot_; }

 private:
  friend class EventBus;

  // An entry of the queue: a message of decisions or, if `decisions` is null, the key of an event
  // in latest_.
  struct Place {
    std::string key;
    EventPtr decisions;
  };

  // Queues the new state of a scene or session. `event` contains it.
  void Put(const std::string& key, const EventPtr& event);
  void PutDecisions(const EventPtr& event);
  // Called before the channel's state is cleared and loaded again. Starts again with the first key.
  void Restart();
  EventPtr NextOfState();
  EventPtr NextOfEarlier();
  EventPtr NextOfQueue();

  EventBus& bus_;
  Wish wish_;
  Sink& sink_;
  std::shared_ptr<Channel> channel_;  // null unless subscribed
  // The last key of the initial state that Take has returned; absent when Take has returned all of
  // it.
  std::optional<std::string> cursor_ = "";
  bool needs_snapshot_ = false;
  std::set<std::string> earlier_;  // the keys of the states before Restart
  std::deque<Place> queue_;        // the oldest entry first
  size_t decision_bytes_ = 0;
  std::map<std::string, EventPtr> latest_;  // the latest event of each key in queue_
};

}  // namespace sweepstake::events
