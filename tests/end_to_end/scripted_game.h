// A game whose arms cost what a script says, connected to a real daemon.
//
// The backends, the frame path, the session and the stream are real; only the time a frame takes is
// scripted: the clock moves by the active arm's cost, so that which arm is best does not depend on
// the machine.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/session.h"

namespace sweepstake::test_support {

// Arms in the order of AdaptiveBroadPhase::arms(), detection per frame.
using ArmCostsMs = std::vector<double>;

// SAP, arm 2, is the best; KDTree the next.
inline const ArmCostsMs kScriptedCosts = {40, 25, 2, 30, 20, 35, 8};
inline constexpr uint32_t kScriptedBest = 2;

// A time scale of 200: a decision every 10 ms, a cooldown of 200 ms. Reconnects fast.
SessionOptions FastOptions();

class ScriptedGame {
 public:
  ScriptedGame(const std::string& address, SessionOptions options,
               ArmCostsMs costs_ms = kScriptedCosts);
  ~ScriptedGame();

  // Runs frames until `done` returns true or `frame_limit` frames have run; returns the former. It
  // waits for the sender between frames, never inside one, so that the queue drops nothing while
  // the daemon runs.
  bool RunUntil(const std::function<bool(const SessionStats&)>& done,
                uint64_t frame_limit = 5'000'000);
  // Runs a few frames, unless the sender is far behind; returns whether it did.
  bool RunSomeFrames();
  // Runs `count` frames without looking at the session at all.
  void RunFrames(uint64_t count);
  // Runs one frame of 8 s, which its arm is to blame for.
  void BailOut();
  void Stop(uint32_t deadline_ms = 5'000);

  SessionStats stats() const { return session_->stats(); }
  AdaptiveBroadPhase& adaptive() { return *adaptive_; }
  uint64_t frame_count() const { return frame_count_; }
  // Calls that can block, made on this thread inside BeginFrame, FindPairs and EndFrame.
  uint64_t wait_count() const { return wait_count_; }

 private:
  class ScriptedClock;
  void RunFrame(bool bails_out);

  ArmCostsMs costs_ms_;
  std::unique_ptr<ScriptedClock> clock_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  std::vector<Aabb> boxes_;
  uint64_t frame_count_ = 0;
  uint64_t wait_count_ = 0;
};

// Evidence in the latest snapshot, priors from the store included: the sum of α + β − 2 over arms.
double LearntEvidence(const SessionStats& stats);

// Whether the daemon has acknowledged something of the game: a condition for RunUntil.
inline bool IsConnected(const SessionStats& stats) { return stats.acknowledged_sequence > 0; }

}  // namespace sweepstake::test_support
