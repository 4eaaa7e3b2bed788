// The events of the daemon for everyone who watches, with one cache of what is watched.
//
// Watchers with the same filter share a channel. It keeps the latest event of each matching scene
// or session, so that a later watcher costs the store nothing. A channel of scenes is filled from
// the store page by page; the figures of a page are computed on the store's reading thread. After
// that the bus reads a scene once more, at its first change, and then adds the increments of each
// commit. Figures are computed once for each change. Changes are published at 4 Hz: one timer runs
// while something has changed. Decisions are published at the same ticks.
//
// Used on the decision loop only. It has no thread, clock or connection of its own. The memory of
// the sums is bounded by kMaxScenes; that of the channels by the quotas of scenes and sessions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/events/event.h"
#include "server/events/subscriber.h"
#include "server/sessions/box_views.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_observer.h"
#include "server/sessions/session_table.h"

namespace sweepstake::events {

// What subscribers with the same filter share.
struct Channel {
  Kind kind = Kind::kPosteriors;
  priors::SceneFilter filter = {};
  std::map<std::string, EventPtr> state = {};  // the latest event of each scene or session
  bool complete = false;                       // the state contains everything that matches
  uint64_t load_count = 0;                     // the results of earlier loads are dropped
  std::vector<Subscriber*> subscribers = {};
  std::unique_ptr<sessions::BoxViewListener> boxes = {};  // for Kind::kBoxes
};

class EventBus final : public sessions::SessionObserver {
 public:
  // The number of scenes that could not be read and are tried again at each tick.
  static constexpr size_t kReadsPerTick = 100;
  // Beyond this number, sums of scenes that are not changing are dropped. They are read again at
  // the next change.
  static constexpr size_t kMaxScenes = 10'000;
  static constexpr uint32_t kPageSize = 100;  // scenes, or sessions, that are loaded at a time
  // The maximum decisions in one message, which then has 130 kB at most.
  static constexpr uint32_t kDecisionsPerMessage = 100;

  // It borrows everything. The store must be closed, and the loop done, before the bus is
  // destroyed.
  EventBus(priors::AsyncPriorStore& store, sessions::DecisionLoop& loop,
           const sessions::SessionTable& sessions, const Encoder& encoder);

  // Begins a subscription, or ends it at once. Errors: UNAVAILABLE (draining, or the store is
  // busy); for boxes: NOT_FOUND, and those of BoxViews::Add.
  void Subscribe(Wish wish, Sink& sink);

  void OnSession(const std::string& session_id, const sessions::SessionChange& change) override;
  bool Watches(const priors::SceneKey& scene) const override;
  void OnDecision(const sessions::DecisionEvent& event) override;
  void OnEvidence(const priors::SceneKey& scene, std::span<const priors::KeyedEvidence> increments,
                  bool new_source) override;
  void Forget(const priors::SceneKey& scene) override { scenes_.erase(scene); }
  void Reload(const priors::SceneKey& scene) override;
  // Called when evidence was imported or revoked: all scenes are read and published again.
  void Reset();
  // Ends the subscriptions of callers that may not watch any more.
  void EndRefused();
  // Ends all subscriptions. No other begins, and the store is not read any more.
  void Drain();

 private:
  friend class Subscriber;
  class BoxFeed;

  struct Scene {
    std::optional<priors::SceneEvidence> sums;  // absent while the store reads them
    bool changed = false;                       // since the last tick
    bool unread = false;                        // the store could not read them: try again
  };
  // The decisions of a scene since the last tick.
  struct Decisions {
    std::string body;
    uint32_t count = 0;
  };
  struct PageScene {
    priors::SceneKey key;
    std::shared_ptr<const std::string> body;
  };
  using ChannelPtr = std::shared_ptr<Channel>;

  absl::Status Join(Subscriber& subscriber);
  absl::Status JoinBoxes(Subscriber& subscriber);
  // Does nothing if it is not subscribed.
  void Remove(Subscriber& subscriber);
  void End(Subscriber& subscriber, const absl::Status& status);
  void EndAll(const absl::Status& status, const Channel* of = nullptr);

  // Fills the channel, from the store or from the table of sessions.
  void LoadScenes(const ChannelPtr& channel, const std::optional<priors::SceneKey>& after);
  void OnScenes(const ChannelPtr& channel, uint64_t last_sequence,
                const std::vector<PageScene>& page);
  void LoadSessions(const ChannelPtr& channel, const std::string& after);

  EventStamp NextStamp();
  EventPtr Mark(Kind kind);
  EventPtr MakeEvent(Kind kind, std::shared_ptr<const std::string> body);
  EventPtr SceneEvent(const priors::SceneKey& key, std::shared_ptr<const std::string> body);
  // Returns the event as it would be made now; null if its session has left memory.
  EventPtr Refreshed(const Channel& channel, const std::string& key, const EventPtr& event);

  // Calls `use` with each channel of the kind that shows the scene.
  template <typename Use>
  void ForEachChannel(Kind kind, const priors::SceneKey& scene, Use use) const;
  static void Put(Channel& channel, const std::string& key, const EventPtr& event);
  static void Wake(const Channel& channel);
  void PublishSessions();
  void PublishDecisions(const priors::SceneKey& scene, Decisions decisions);
  void PublishScene(const priors::SceneEvidence& scene);

  void Load(const priors::SceneKey& key);
  // Reads the scene at the next tick, or at a later one.
  void LoadLater(Scene& scene);
  void LoadUnread();
  void OnLoaded(const priors::SceneKey& key,
                const absl::StatusOr<std::optional<priors::SceneEvidence>>& loaded);
  void ScheduleTick();
  void Tick();

  priors::AsyncPriorStore& store_;
  sessions::DecisionLoop& loop_;
  const sessions::SessionTable& sessions_;
  const Encoder& encoder_;
  const uint64_t boot_;
  uint64_t last_sequence_ = 0;
  std::map<std::pair<Kind, priors::SceneFilter>, ChannelPtr> channels_;  // without those of boxes
  std::set<Subscriber*> subscribers_;
  std::map<priors::SceneKey, Scene> scenes_;
  std::map<priors::SceneKey, Decisions> decisions_;
  std::map<std::string, sessions::SessionChange> changed_sessions_;  // since the last tick, by id
  bool tick_scheduled_ = false;
  bool draining_ = false;
};

}  // namespace sweepstake::events
