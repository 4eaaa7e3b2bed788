// One object that owns a game's frame path and the session that decides for it.
//
//   auto game = AdaptiveSession::Create(MakeEmbeddedSession({.scene = "hall"}));
//   if (!game.ok()) return Fail(game.status().message());
//   for (;;) {
//     game->BeginFrame();                           // executes a pending switch
//     for (const auto [a, b] : game->FindPairs(boxes)) Collide(a, b);
//     game->EndFrame({.frame_time_ns = dt});
//   }
//
// For a game with a daemon, replace MakeEmbeddedSession by MakeDaemonSession. The parts stay
// available: broad_phase() and session(). They may also be made and destroyed one by one, in any
// order (adaptive_broad_phase.h, session.h).
//
// Thread safety, cost and errors: as AdaptiveBroadPhase. The destructor ends the session's thread
// without waiting for a daemon. Call session().Stop() before, if the daemon shall confirm the last
// evidence.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/session.h"
#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

class AdaptiveSession {
 public:
  // Makes the broad phase and starts the session with it. Errors: that of `session`, and those of
  // AdaptiveBroadPhase::Create and Session::Start.
  static Result<AdaptiveSession> Create(Result<std::unique_ptr<Session>> session,
                                        const AdaptiveOptions& options = {});

  // A moved-from object may only be destroyed or assigned to.
  AdaptiveSession(AdaptiveSession&&) noexcept = default;
  AdaptiveSession& operator=(AdaptiveSession&&) noexcept = default;
  ~AdaptiveSession() = default;

  // The functions of a frame: those of AdaptiveBroadPhase.
  void BeginFrame() { broad_phase_->BeginFrame(); }
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes) {
    return broad_phase_->FindPairs(boxes);
  }
  void EndFrame(const FrameEnd& frame) { broad_phase_->EndFrame(frame); }

  // Returns the name of the active arm.
  const std::string& arm() const { return broad_phase_->arms()[broad_phase_->active_arm()]; }

  AdaptiveBroadPhase& broad_phase() { return *broad_phase_; }
  const AdaptiveBroadPhase& broad_phase() const { return *broad_phase_; }
  Session& session() { return *session_; }
  const Session& session() const { return *session_; }

 private:
  AdaptiveSession(std::unique_ptr<Session> session, std::unique_ptr<AdaptiveBroadPhase> broad_phase)
      : session_(std::move(session)), broad_phase_(std::move(broad_phase)) {}

  std::unique_ptr<Session> session_;
  std::unique_ptr<AdaptiveBroadPhase> broad_phase_;
};

}  // namespace sweepstake

#include "sweepstake/names/end.h"
