// A game with scripted arm costs, connected to a real daemon.
//
// The backends, the frame path, the session and the stream are real. Only the frame time is
// scripted: the clock advances by the active arm's cost, so that the best arm does not depend on
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

// Detection time per frame, in the order of AdaptiveBroadPhase::arms().
using ArmCostsMs = std::vector<double>;

// SAP, arm 2, is the best; KDTree is the second.
inline const ArmCostsMs kScriptedCosts = {40, 25, 2, 30, 20, 35, 8};
inline constexpr uint32_t kScriptedBest = 2;

// Returns options with time scale 200 (decisions every 10 ms, cooldown 200 ms) and fast reconnects.
SessionOptions FastOptions();

class ScriptedGame {
 public:
  ScriptedGame(const std::string& address, SessionOptions options,
               ArmCostsMs costs_ms = kScriptedCosts);
  ~ScriptedGame();

  // Runs frames until `done` returns true or `frame_limit` frames have run; returns whether `done`
  // was true. It waits for the sender between frames, never inside one, so that the queue drops
  // nothing while the daemon runs.
  bool RunUntil(const std::function<bool(const SessionStats&)>& done,
                uint64_t frame_limit = 5'000'000);
  // Runs a few frames unless the sender is far behind; returns whether it ran them.
  bool RunSomeFrames();
  // Runs `count` frames without checking the session.
  void RunFrames(uint64_t count);
  // Runs one frame of 8 s that its arm causes.
  void BailOut();
  void Stop(uint32_t deadline_ms = 5'000);

  SessionStats stats() const { return session_->stats(); }
  AdaptiveBroadPhase& adaptive() { return *adaptive_; }
  uint64_t frame_count() const { return frame_count_; }
  // Number of calls that can block, made on this thread inside BeginFrame, FindPairs and EndFrame.
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

// Returns the evidence in the latest snapshot, including the store's priors: the sum of α + β − 2
// over the arms.
double LearntEvidence(const SessionStats& stats);

// Whether the daemon has acknowledged a message of the game: a condition for RunUntil.
inline bool IsConnected(const SessionStats& stats) { return stats.acknowledged_sequence > 0; }

}  // namespace sweepstake::test_support
