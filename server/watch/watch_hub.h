// The sums of the scenes that somebody watches, kept in memory, and who is told when they change.
//
// A posterior is Beta(1,1) plus all committed evidence. The hub reads a watched scene from the
// store once, at its first change, and then adds the increments of each commit, so that watchers
// cost the store nothing while games learn. Changes of posteriors and sessions are told at 4 Hz:
// one timer runs while something has changed, and none otherwise. Listeners hear of decisions at
// once and pass them on at the same ticks.
//
// It is used on the decision loop only. It has no thread, clock or connection of its own, so that
// every service that shows posteriors can listen to the same hub. The memory is bounded by
// kMaxScenes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"
#include "server/sessions/session_observer.h"

namespace sweepstake::watch {

// Which event of which daemon it is, and when it was made.
struct EventStamp {
  uint64_t boot = 0;      // a random number of the daemon's run
  uint64_t sequence = 0;  // of the events of the run, from 1 on
  int64_t unix_ms = 0;
};

using SessionChanges = std::map<std::string, sessions::SessionChange>;  // by session

// Is told which sessions have begun, ended or changed. It must not call the hub back.
class SessionListener {
 public:
  virtual ~SessionListener() = default;

  // Returns whether anybody watches sessions.
  virtual bool WatchesSessions() const = 0;
  virtual void OnSessions(const SessionChanges& changes) = 0;
};

// Passes on what the hub tells, as the watchers of one service. It must not call the hub back.
class WatchListener {
 public:
  virtual ~WatchListener() = default;

  virtual bool Watches(const priors::SceneKey& scene) = 0;
  // OnDecision and OnPosterior are called for watched scenes only.
  virtual void OnDecision(const sessions::DecisionEvent& event) = 0;
  // A tick begins, up to kIntervalNs after the decisions that it was not called for yet.
  virtual void OnTick() = 0;
  virtual void OnPosterior(const priors::SceneEvidence& scene) = 0;
  // Called when any scene may have changed: all must be read again.
  virtual void OnReset() = 0;
};

class WatchHub final : public sessions::SessionObserver {
 public:
  // Of the scenes that could not be read, so many are tried again at a tick.
  static constexpr size_t kReadsPerTick = 100;
  // Beyond it, scenes that are not changing are dropped and read again at their next change.
  static constexpr size_t kMaxScenes = 10'000;

  // How the hub runs tasks on the decision loop. `post` may be called from any thread.
  struct Loop {
    std::function<void(std::function<void()>)> post;
    std::function<void(int64_t delay_ns, std::function<void()>)> post_after;
  };

  // The store must be closed, and the loop done, before the hub is destroyed.
  WatchHub(priors::AsyncPriorStore& store, Loop loop);

  void Add(WatchListener& listener) { listeners_.push_back(&listener); }
  void Add(SessionListener& listener) { session_listeners_.push_back(&listener); }

  // Returns the stamp of the next event.
  EventStamp NextStamp();
  void OnSession(const std::string& session_id, const sessions::SessionChange& change) override;
  bool Watches(const priors::SceneKey& scene) const override;
  void OnDecision(const sessions::DecisionEvent& event) override;
  void OnEvidence(const priors::SceneKey& scene, std::span<const priors::KeyedEvidence> increments,
                  bool new_source) override;
  void Forget(const priors::SceneKey& scene) override { scenes_.erase(scene); }
  void Reload(const priors::SceneKey& scene) override;
  // Called when evidence was imported or revoked: forgets all sums.
  void Reset();
  // Tells no more posteriors and asks the store for nothing any more.
  void Drain();

 private:
  struct Scene {
    std::optional<priors::SceneEvidence> sums;  // absent while the store reads them
    bool changed = false;                       // since the last tick
    bool unread = false;                        // the store could not read them: try again
  };

  void Load(const priors::SceneKey& key);
  // Reads the scene at the next tick, or at one after it.
  void LoadLater(Scene& scene);
  void LoadUnread();
  void OnLoaded(const priors::SceneKey& key,
                const absl::StatusOr<std::optional<priors::SceneEvidence>>& loaded);
  void ScheduleTick();
  void Tick();
  void TellSessions();

  priors::AsyncPriorStore& store_;
  const Loop loop_;
  const uint64_t boot_;
  uint64_t last_sequence_ = 0;
  std::vector<WatchListener*> listeners_;
  std::vector<SessionListener*> session_listeners_;
  std::map<priors::SceneKey, Scene> scenes_;
  SessionChanges sessions_;  // since the last tick
  bool tick_scheduled_ = false;
  bool draining_ = false;
};

}  // namespace sweepstake::watch
