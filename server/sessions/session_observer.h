// The interface that receives the changes of all sessions and publishes them to watchers.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine_client/decider/session/decision_observer.h"
#include "server/sessions/common/log_histogram.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_identity.h"

namespace sweepstake::sessions {

// Why a session has left memory; kNone: it is in memory. The values are those of v1::SessionEnd.
enum class SessionEnd : uint8_t { kNone, kGoodbye, kKicked, kForgotten };

// A change of a session. SessionTable::Describe returns its present state.
struct SessionChange {
  priors::SceneKey scene;
  SessionEnd end = SessionEnd::kNone;
};

// A decision of a session. All pointers and references are borrowed.
struct SessionDecision {
  const SessionIdentity& session;
  const decision::DecisionRecord& record;
  int64_t unix_ms = 0;
  const FrameHistograms* measurements =
      nullptr;  // cost of frames since the previous measurements; null if none are due
};

// The functions are called on the decision loop. They must not call functions of sessions.
class SessionObserver {
 public:
  // Minimum interval between two measurements in the decisions of a session.
  static constexpr int64_t kIntervalNs = 250'000'000;

  virtual ~SessionObserver() = default;

  // Called when a session has begun, ended or changed.
  virtual void OnSession(const std::string& session_id, const SessionChange& change) = 0;
  // Returns whether anybody watches this scene. If not, OnDecision need not be called.
  virtual bool Watches(const priors::SceneKey& scene) const = 0;
  virtual void OnDecision(const SessionDecision& event) = 0;
  // Called when increments of the scene have reached the disk. `new_source` is true if they are the
  // first ones of their session.
  virtual void OnEvidence(const priors::SceneKey& scene,
                          std::span<const priors::KeyedEvidence> increments, bool new_source) = 0;
  // Reads the sums of the scene from the store again and publishes them. Called because the store
  // may contain, or still receive, increments for which OnEvidence is not called, or because the
  // sums may already contain the increments of the next OnEvidence.
  virtual void Reload(const priors::SceneKey& scene) = 0;
};

}  // namespace sweepstake::sessions
