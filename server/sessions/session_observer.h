// Receives the changes of sessions, for people who watch them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine_client/decider/session/decision_observer.h"
#include "server/sessions/common/log_histogram.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_identity.h"

namespace sweepstake::sessions {

// Why a session has left memory. Numbered as v1::SessionEnd.
enum class SessionEnd : uint8_t { kNone, kGoodbye, kKicked, kForgotten };

// A change of a session. SessionTable has its present state.
struct SessionChange {
  priors::SceneKey scene;
  SessionEnd end = SessionEnd::kNone;
};

// A decision of a session. It borrows everything.
struct DecisionEvent {
  const SessionIdentity& session;
  const decision::DecisionRecord& record;
  int64_t unix_ms = 0;
  const FrameHistograms* measurements =
      nullptr;  // what frames cost since the last ones; may be null
};

// Called on the decision loop. It does not call sessions back.
class SessionObserver {
 public:
  // At this interval at most, decisions come with measurements.
  static constexpr int64_t kIntervalNs = 250'000'000;

  virtual ~SessionObserver() = default;

  // A session has begun, ended or changed.
  virtual void OnSession(const std::string& session_id, const SessionChange& change) = 0;
  // Returns whether anybody watches this scene. If not, OnDecision need not be called.
  virtual bool Watches(const priors::SceneKey& scene) const = 0;
  virtual void OnDecision(const DecisionEvent& event) = 0;
  // Increments of the scene have reached the disk. `new_source` says that they are the first of
  // their session.
  virtual void OnEvidence(const priors::SceneKey& scene,
                          std::span<const priors::KeyedEvidence> increments, bool new_source) = 0;
  // It is unknown whether the scene's stored sums already contain the next increments: the sums are
  // read again with them.
  virtual void Forget(const priors::SceneKey& scene) = 0;
  // The disk may have, or get, increments of the scene that no OnEvidence will follow: its sums are
  // read again and published.
  virtual void Reload(const priors::SceneKey& scene) = 0;
};

}  // namespace sweepstake::sessions
