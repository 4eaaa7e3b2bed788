// Publishes the daemon's events (posteriors, sessions, boxes) to watchers, and caches the state
// that they watch.
//
// Watchers with the same filter share a channel. The channel keeps the latest event of each
// matching scene or session, so that a further watcher needs no read of the store.
//
// A channel of scenes is filled from the store page by page. The store's reading thread computes
// the verdicts and intervals of the scenes. At the first change of a scene, the bus reads the
// scene's sums of evidence from the store. From then on it adds the increments of each commit to
// these sums.
//
// Changes and decisions are published every 250 ms. The timer runs only while something has
// changed.
//
// Used on the decision loop only. It has no thread, clock or connection of its own. kMaxScenes
// bounds the memory of the sums. The quotas of scenes and sessions bound the memory of the
// channels.
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

// The state that subscribers with the same filter share.
struct Channel {
  Kind kind = Kind::kPosteriors;
  priors::SceneFilter filter = {};
  std::map<std::string, EventPtr> state = {};  // the latest event of each scene or session
  bool complete = false;                       // whether `state` has every match
  uint64_t load_count = 0;  // number of the latest load; results of earlier loads are dropped
  std::vector<Subscriber*> subscribers = {};
  // Receives box views; null for the other kinds.
  std::unique_ptr<sessions::BoxViewListener> boxes = {};
};

class EventBus final : public sessions::SessionObserver {
 public:
  // Maximum number of failed reads of scenes that are repeated per tick.
  static constexpr size_t kReadsPerTick = 100;
  // If more scenes than this are in memory, the sums of scenes without a pending change are
  // dropped. They are read again at the scene's next change. Scenes that are being read are kept.
  static constexpr size_t kMaxScenes = 10'000;
  static constexpr uint32_t kPageSize = 100;  // scenes or sessions per page of a load
  // Maximum number of decisions in one message. It limits the message to 130 kB.
  static constexpr uint32_t kDecisionsPerMessage = 100;

  // Borrows all arguments. REQUIRES: the store is closed and the loop has ended before the bus is
  // destroyed.
  EventBus(priors::AsyncPriorStore& store, sessions::DecisionLoop& loop,
           const sessions::SessionTable& sessions, const Encoder& encoder);

  // Begins a subscription. An error ends it with Sink::OnEnd:
  // - UNAVAILABLE: the daemon is draining, or the store is busy.
  // - For boxes: NOT_FOUND (the filter does not match an active session with this id), and the
  //   errors of BoxViews::Add.
  void Subscribe(Wish wish, Sink& sink);

  void OnSession(const std::string& session_id, const sessions::SessionChange& change) override;
  bool Watches(const priors::SceneKey& scene) const override;
  void OnDecision(const sessions::SessionDecision& event) override;
  void OnEvidence(const priors::SceneKey& scene, std::span<const priors::KeyedEvidence> increments,
                  bool new_source) override;
  void Reload(const priors::SceneKey& scene) override;
  // Called after evidence was imported, promoted or revoked. All watched scenes are read and
  // published again. A scene that has no evidence any more is published without arms. Subscribers
  // with Wish::snapshots receive a snapshot, which lacks such scenes.
  void Reset();
  // Ends the subscriptions whose Wish::check returns an error, for instance because the token was
  // revoked.
  void EndRefused();
  // Ends all subscriptions and refuses new ones. The store is not read any more.
  void Drain();

 private:
  friend class Subscriber;
  class BoxFeed;

  struct Scene {
    std::optional<priors::SceneEvidence> sums;  // absent while the store reads them
    bool changed = false;                       // whether it changed since the last tick
    bool unread = false;  // whether the last read failed; a later tick repeats it
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
  // Does nothing if the subscriber is not subscribed.
  void Remove(Subscriber& subscriber);
  void End(Subscriber& subscriber, const absl::Status& status);
  void EndAll(const absl::Status& status, const Channel* of = nullptr);

  // Fill the channel page by page: scenes from the store, sessions from the table of sessions.
  void LoadScenes(const ChannelPtr& channel, const std::optional<priors::SceneKey>& after);
  void OnScenes(const ChannelPtr& channel, uint64_t last_sequence,
                const std::vector<PageScene>& page);
  void LoadSessions(const ChannelPtr& channel, const std::string& after);

  EventStamp NextStamp();
  EventPtr MakeEvent(Kind kind, std::shared_ptr<const std::string> body);
  EventPtr SceneEvent(const priors::SceneKey& key, std::shared_ptr<const std::string> body);
  // Returns an event for a scene that has no evidence any more.
  EventPtr EmptyScene(const std::string& key);
  // Returns a new event for the scene or session of `event`, with the present activity or state.
  // Returns null if the session has left memory.
  EventPtr Refreshed(const Channel& channel, const std::string& key, const EventPtr& event);

  // Calls `use` with each channel of the kind whose filter matches the scene.
  template <typename Use>
  void ForEachChannel(Kind kind, const priors::SceneKey& scene, Use use) const;
  static void Put(Channel& channel, const std::string& key, const EventPtr& event);
  static void Wake(const Channel& channel);
  void PublishSessions();
  // Publishes the scenes again whose sessions run something else than at the last publication.
  void PublishRuns();
  void PublishDecisions(const priors::SceneKey& scene, Decisions decisions);
  void PublishScene(const priors::SceneEvidence& scene);

  void Load(const priors::SceneKey& key);
  // Schedules a read of the scene for one of the next ticks. A tick makes at most kReadsPerTick
  // reads.
  void LoadLater(Scene& scene);
  void LoadUnread();
  // Returns whether watchers have the scene.
  bool IsPublished(const priors::SceneKey& key) const;
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
  // channels of boxes are not in it
  std::map<std::pair<Kind, priors::SceneFilter>, ChannelPtr> channels_;
  std::set<Subscriber*> subscribers_;
  std::map<priors::SceneKey, Scene> scenes_;
  std::map<priors::SceneKey, Decisions> decisions_;
  std::map<std::string, sessions::SessionChange> changed_sessions_;  // since the last tick, by id
  std::set<priors::SceneKey> session_scenes_;  // scenes of the sessions that changed since then
  bool tick_scheduled_ = false;
  bool draining_ = false;
};

}  // namespace sweepstake::events
