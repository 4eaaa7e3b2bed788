// "AI Decides" without a daemon: the daemon's decision core runs in the game process and starts
// from priors.
//
// ExportPriors returns the priors that the decider started from, together with what it has learnt
// since. Use the result in the next run, or import it into a daemon (`sweepstake priors import`):
//
//   options.source_id = installation_id;              // the same in each run
//   options.priors_data = ReadSave("priors.json");    // empty in the first run
//   ... the game runs ...
//   WriteSave("priors.json", decider->ExportPriors());
//
// Not thread-safe. The owner calls it from one thread: a worker, or the frame thread if the game
// accepts the cost of a decision every 2 s. It needs no gRPC, no network and no thread of its own.
// Decisions do not depend on the caller's floating-point environment; callbacks run in the default
// one.
#pragma once

#include <cstdint>
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

// A posterior of an arm's reward, Beta(alpha, beta).
struct ArmBelief {
  std::string arm;
  double alpha = 1;
  double beta = 1;
  // The arm's standing; absent while nothing has been learnt.
  std::optional<ArmStanding> standing{};
};

// One decision, as passed to EmbeddedOptions::on_decision.
struct DecisionEvent {
  uint64_t decision_id = 0;  // counts from 1
  uint64_t time_ns = 0;      // on the clock of the caller's now_ns
  uint32_t active_arm = 0;
  // The arm that the policy proposed; absent if it proposed none.
  std::optional<uint32_t> candidate_arm;
  DecisionOutcome outcome = DecisionOutcome::kKept;
  // The switch that was commanded; absent if there was none.
  std::optional<SwitchCommand> command;
  // The reward of the frames since the previous decision, 0–1; absent if there was nothing to learn
  // from them.
  std::optional<double> reward;
  // The posteriors after the update, in the order of the arms.
  std::vector<ArmBelief> beliefs;
  // The probability of each arm of being the best; empty while nothing is known.
  std::vector<double> best_probability;
  // The expected loss of choosing the leader, relative to the cost of the best arm.
  double expected_loss_ratio = 0;
  SceneVerdict verdict;
};

struct EmbeddedOptions {
  // Name of the policy. "default" is "adaptive", the policy of AI Decides, which compares expected
  // costs; "paper" is Thompson sampling.
  std::string policy = "default";
  // The priors are stored by project, scene, machine class and backend version.
  std::string project = "default";
  std::string scene = "default";
  std::string machine_class = {};  // class of comparable machines; empty: MachineClass()
  std::string build = {};  // the game's build; evidence from others counts less. Empty: unknown
  // Priors to start from, as `sweepstake priors export` and ExportPriors write them: the path of a
  // file (in UTF-8), their text, or both. An example of both: priors that came with the game, and
  // priors that it saved. They are merged; evidence that is in both counts once, in its later
  // version. Both empty: Beta(1,1).
  std::string priors_file = {};
  std::string priors_data = {};
  // The name under which evidence is exported, at most 128 bytes. A game that keeps a name per
  // installation, such as a random number, has one record per arm. The record grows from run to
  // run, and in a store the later record replaces the earlier one. Two installations must not share
  // a name. An installation that loses its save needs a new name: the sequence numbers of its
  // records begin at 1 again, and a store that has higher numbers ignores these records.
  //
  // Empty: a new name in each run. A save that is loaded and exported again then grows by the
  // records of each run; above 200,000 records it is refused.
  std::string source_id = {};
  uint64_t seed = 1;
  double time_scale = 1;  // 1–1000: divides every interval except the bail-out limit
  // Weights of the paper's reward. Other weights than these have a reward version of their own, so
  // their evidence is never merged with that of these.
  RewardWeights weights = {};
  // Time between decisions, 1 ns to 100 days. A decision learns from the mean over this time. AI
  // Decides (policy `adaptive`) decides at least every second, and when the scene changes.
  uint64_t decision_interval_ns = 2'000'000'000;
  // Minimum time from an executed switch to the next one that the policy chooses, at most 100 days.
  // AI Decides waits only for settling_ns plus one interval (2 s by default). Bail-outs do not
  // wait.
  uint64_t cooldown_ns = 40'000'000'000;
  // Frame time after a switch that is excluded from learning, at most 100 days; AI Decides: at most
  // 1 s. A trial lasts for twice this time; with 0 no trials are made.
  uint64_t settling_ns = 2'000'000'000;
  // The frame-rate floor in frames/s, 0–1000. A scene that misses it even with its best arm, and
  // because of the broad phase, gets the verdict kDegraded. With 0, no scene gets it.
  double fps_floor = 30;
  Mode mode = Mode::kAi;
  // Index of the arm with which the game begins, for SessionStats::saved_us. AdaptiveBroadPhase
  // knows it.
  uint32_t initial_arm = 0;
  // Called with every decision, on the thread that drives the decider. It must not call the
  // decider.
  std::function<void(const DecisionEvent&)> on_decision = nullptr;
  // Called with every row of the audit log, on the thread that drives the decider; it must not call
  // the decider. A row is one or more lines of CSV without the last line end.
  // EmbeddedDecider::AuditHeader() is the header. Null: no log is written.
  std::function<void(std::string_view row)> on_audit_row = nullptr;
};

class EmbeddedDecider {
 public:
  // Makes a decider. `arms` and `arm_versions` are those of the AdaptiveBroadPhase. Errors:
  // kInvalidArgument, kNotFound (no such file), kDataLoss (broken priors; the message is one line
  // and names the record).
  static Result<std::unique_ptr<EmbeddedDecider>> Create(const EmbeddedOptions& options,
                                                         std::span<const std::string> arms,
                                                         std::span<const uint32_t> arm_versions,
                                                         uint64_t now_ns);
  ~EmbeddedDecider();

  // Returns the arm that the priors expect to cost least, for AdaptiveBroadPhase::Freeze. Only arms
  // that the priors contain are considered. The same priors give the same arm on any machine, at
  // any time and with any seed. Errors: those of Create, and kNotFound if the priors have no
  // evidence of the project with these arms.
  static Result<std::string> ArmOfPriors(const EmbeddedOptions& options,
                                         std::span<const std::string> arms,
                                         std::span<const uint32_t> arm_versions);

  // Returns the header line of the audit log, without a line end.
  static std::string AuditHeader();

  // Adds frames and switch outcomes, in the order in which they happened.
  void Observe(std::span<const FrameSample> frames, uint64_t now_ns);
  void Observe(const SwitchOutcome& outcome, uint64_t now_ns);
  // Adds the shadow lane's samples and the scene's descriptor. The next decision learns from both.
  void Observe(std::span<const ShadowSample> samples);
  void Observe(const SceneDescriptor& descriptor);
  void SetMode(Mode mode, uint32_t active_arm, uint64_t now_ns);

  // Makes a decision if one is due, and returns its command, if any. The returned command may also
  // come from an earlier bail-out. The caller must post it into the mailbox.
  std::optional<SwitchCommand> Poll(uint64_t now_ns);

  // Returns the settling time of the policy, divided by the time scale, for
  // AdaptiveBroadPhase::SetSettling.
  uint64_t settling_ns() const;
  // Returns whether the policy learns from the shadow lane, for AdaptiveBroadPhase::SetLaneUse.
  bool uses_shadow() const;
  std::vector<ArmBelief> beliefs() const;
  // Returns the verdict of the latest decision.
  SceneVerdict verdict() const;
  // Returns SessionStats::saved_us.
  std::optional<double> saved_us() const;
  // Returns the latest decision, with its reasons; absent before the first.
  const std::optional<DecisionEvent>& last_decision() const;
  uint64_t decision_count() const;
  // Returns the number of sources (sessions) in the priors that the decider started from; 0 if it
  // started from Beta(1,1).
  uint64_t prior_source_count() const;
  // Returns the text of a priors file with all given records and the evidence learnt since. If the
  // text is imported or merged with other priors, each piece of evidence counts once, however often
  // it occurs. Cost: linear in the number of records, about 400 bytes each.
  std::string ExportPriors() const;

 private:
  class Impl;
  friend struct StudyMaker;  // part of the implementation
  explicit EmbeddedDecider(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake
