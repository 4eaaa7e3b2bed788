// One game's decisions: frames in, rewards to posteriors, posteriors to switch commands (steps 8
// and 9 of the one path).
//
// Deterministic: the same setup and the same calls give the same decisions bit for bit on every
// platform. Time and randomness come in as arguments. Not thread-safe; distinct sessions are
// independent. Memory is bounded by the number of arms. Decision times come from the caller's
// clock, settling and warm-up from the frames' own times.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/decision/options.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

struct SessionSetup {
  DecisionOptions options;
  std::vector<std::string> arms;      // 1–32, unique, not empty
  std::vector<BetaPosterior> priors;  // as many as arms; empty: Beta(1,1) each
  uint64_t seed = 1;                  // of the exploration order and of all draws
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
  uint32_t switch_epoch = 0;
  int64_t start_ns = 0;
  // For a session that goes on after a restart: arms explored already, and decisions taken already.
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
};

// What is wrong with the setup, one line; absent when it is valid.
std::optional<std::string> Validate(const SessionSetup& setup);

class DecisionSession {
 public:
  // REQUIRES: !Validate(setup).
  explicit DecisionSession(SessionSetup setup);
  ~DecisionSession();
  DecisionSession(DecisionSession&&) noexcept;
  DecisionSession& operator=(DecisionSession&&) noexcept;

  // Folds frames into the window of the running tick. Frames of another switch epoch or arm than
  // the active one, settling frames, and frames flagged paused or loading are counted and left out.
  void ObserveFrames(std::span<const Frame> frames);

  // A frame over the limit, at once (decision.md §1 "bail-out"). Frames whose detection is under
  // half of the frame, or that are flagged paused or loading, are recorded and not blamed: no
  // increment, no command. At most one per frame index is the caller's to keep.
  Decision ObserveBailOut(const Frame& frame, int64_t now_ns);

  // The client's answer to a command, or a local switch (command_id 0): the new arm is active from
  // this epoch on. REQUIRES: arm < arms.
  void ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason, int64_t now_ns);

  // REQUIRES: arm < arms.
  void SetMode(Mode mode, uint32_t active_arm, int64_t now_ns);

  // When the next tick is due.
  int64_t next_tick_ns() const;
  // Update, then sample, then gate (decision.md §1 "order at a tick"). A late tick is one tick,
  // never several. REQUIRES: now_ns >= next_tick_ns().
  Decision Tick(int64_t now_ns);

  std::span<const BetaPosterior> posteriors() const;
  uint32_t active_arm() const;
  Mode mode() const;
  bool exploring() const;
  uint32_t explored_arm_count() const;
  uint64_t decision_count() const;
  const std::vector<std::string>& arms() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake::decision
