// "AI Decides" without a daemon: the daemon's decision core in the game process, starting from a
// priors file.
//
// Driven by its owner from one thread of its choice (a worker, or the frame thread of a game that
// accepts the cost of a decision every 2 s); not thread-safe otherwise. Needs no gRPC, no network,
// no thread of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"

namespace sweepstake {

namespace decision {
struct Decision;  // server/decision/types.h
}

struct EmbeddedOptions {
  std::string policy = "default";  // that of AI Decides
  std::string project =
      "default";  // key of the priors, with scene, machine class and backend version
  std::string scene = "default";
  std::string machine_class;
  std::filesystem::path priors_file;  // as written by `sweepstake priors export`; empty: Beta(1,1)
  uint64_t seed = 1;
  double time_scale = 1;  // 1–1000: every interval but the bail-out limit is divided by it
  Mode mode = Mode::kAi;
  // Is told every decision as it is made, on the thread that drives the decider; must not call it.
  std::function<void(const decision::Decision&)> on_decision = nullptr;
  // Gets every row of the audit log, as on_decision: a line of CSV without its end; the header is
  // decision::AuditHeader() (server/decision/audit_log.h). Null: none is made.
  std::function<void(std::string_view row)> on_audit_row = nullptr;
};

// A posterior of an arm's reward.
struct ArmBelief {
  std::string arm;
  double alpha = 1;
  double beta = 1;
};

class EmbeddedDecider {
 public:
  // Arms as in AdaptiveBroadPhase::arms() and arm_versions(). kInvalidArgument, kNotFound (no such
  // file), kDataLoss (broken priors file: one line naming the record).
  static Result<std::unique_ptr<EmbeddedDecider>> Create(const EmbeddedOptions& options,
                                                         std::span<const std::string> arms,
                                                         std::span<const uint32_t> arm_versions,
                                                         uint64_t now_ns);
  ~EmbeddedDecider();

  // Takes frames and switch outcomes in the order they happened.
  void Observe(std::span<const FrameSample> frames, uint64_t now_ns);
  void Observe(const SwitchOutcome& outcome, uint64_t now_ns);
  // What the shadow lane measured, and what the scene looks like; learnt at the next decision.
  void Observe(std::span<const ShadowSample> samples);
  void Observe(const SceneDescriptor& descriptor);
  void SetMode(Mode mode, uint32_t active_arm, uint64_t now_ns);

  // Decides where a decision is due or a bail-out was observed; a command is to be posted into the
  // mailbox.
  std::optional<SwitchCommand> Poll(uint64_t now_ns);

  std::vector<ArmBelief> beliefs() const;
  // Of the latest decision.
  SceneVerdict verdict() const;
  uint64_t decision_count() const;
  // Sources (sessions) in the priors it started from; 0: Beta(1,1).
  uint64_t prior_source_count() const;

 private:
  class Impl;
  explicit EmbeddedDecider(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake
