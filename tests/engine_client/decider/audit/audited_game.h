// A session with an audit log, and a game that sends it every kind of input, at random from a seed:
// frames of any epoch, mode changes, bail-outs, shadow samples and descriptors. Its switches are
// executed, refused, local, or reported late.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {

// Keeps the rows.
class AuditFile final : public AuditSink {
 public:
  void OnAuditRow(const AuditRow& row) override { rows.push_back(row); }

  std::vector<AuditRow> rows;
};

// Returns a setup of seven arms whose names need quotes and escapes, with the paper's options.
SessionSetup AuditedSetup(uint64_t seed, std::string_view policy);

class AuditedGame {
 public:
  // A null `file` means no log.
  AuditedGame(const SessionSetup& setup, AuditFile* file, uint32_t segment = 1);

  void Run(int steps);

  DecisionSession& session() { return session_; }
  const std::vector<Decision>& decisions() const { return decisions_; }

 private:
  bool OneIn(uint32_t n) { return random_.NextBelow(n) == 0; }
  uint32_t AnyArm() { return random_.NextBelow(arm_count_); }
  FrameSample NextFrame();
  void Step();
  void Observe(uint32_t frame_count);
  void Answer();
  void SeeScene();
  void Take(Decision decision);

  RandomStream random_;
  DecisionSession session_;
  uint32_t arm_count_;
  int64_t now_ns_;
  uint32_t arm_;
  uint32_t epoch_;
  bool reported_ = true;
  std::optional<SwitchCommand> command_;
  std::vector<Decision> decisions_;
};

}  // namespace sweepstake::decision
