// "AI Decides" without a daemon: the daemon's decision core runs in the game process and starts
// from priors.
//
// What is learnt is not lost: ExportPriors gives the priors together with what was learnt since,
// for the next run to start from, or for a daemon (`sweepstake priors import`):
//
//   options.source_id = installation_id;              // the same in each run
//   options.priors_data = ReadSave("priors.json");    // empty in the first run
//   ... the game runs ...
//   WriteSave("priors.json", decider->ExportPriors());
//
// The owner drives it from one thread of its choice: a worker, or the frame thread of a game that
// accepts the cost of a decision every 2 s. It is not thread-safe otherwise. It needs no gRPC, no
// network and no thread of its own.
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

// An arm's cost ÷ that of the arm that is the best most probably. It is below the median as
// probably as above, and from low to high with a probability of 95 %.
struct CostRatio {
  double median = 1;
  double low = 1;
  double high = 1;
};

// What a session has measured of an arm, and what follows from it in units that people read.
struct ArmStanding {
  uint64_t live_window_count = 0;  // decision windows in which the arm was active and learnt from
  uint64_t lane_visit_count = 0;   // visits of the shadow lane that were learnt from
  // The width of the posterior as a number: so many live windows of an arm that does not change
  // would leave it. What priors and the lane tell is included.
  double effective_window_count = 0;
  double best_probability = 0;  // the probability to be the best arm
  // Absent while nothing is known, and where the policy's reward is not of the cost alone.
  std::optional<CostRatio> cost_ratio;
};

// A posterior of an arm's reward, Beta(alpha, beta).
struct ArmBelief {
  std::string arm;
  double alpha = 1;
  double beta = 1;
  // Absent while nothing is learnt, and from a daemon that does not tell.
  std::optional<ArmStanding> standing{};
};

// One decision, as EmbeddedOptions::on_decision gets it.
struct DecisionEvent {
  uint64_t decision_id = 0;  // from 1
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
  // The probability of each arm to be the best; empty while nothing is known.
  std::vector<double> best_probability;
  // The expected loss of choosing the leader, relative to the cost of the best arm.
  double expected_loss_ratio = 0;
  SceneVerdict verdict;
};

struct EmbeddedOptions {
  std::string policy = "default";  // that of AI Decides
  // The priors are stored by project, scene, machine class and backend version.
  std::string project = "default";
  std::string scene = "default";
  std::string machine_class;  // machines whose timings compare; empty: MachineClass() says it
  std::string build;          // of the game; what others taught counts less. Empty: unknown
  // Priors to start from, as `sweepstake priors export` and ExportPriors write them: the path of a
  // file (in UTF-8), their text, or both, for example those that came with the game and those that
  // it saved. They are united; of evidence that is in both, the later counts. Empty: Beta(1,1).
  std::string priors_file;
  std::string priors_data;
  // What is learnt is exported under this name, at most 128 bytes. A game that keeps a name per
  // installation, such as a random number, has one record per arm that grows from run to run, which
  // a store takes in place of the earlier one. Two installations must not share one, and one that
  // loses its save needs a new one: the numbers of its records begin at 1 again, and a store that
  // has later ones ignores them. Empty: a new name in each run, so that a save which is given back
  // and exported again grows by the records of each run; at 200,000 records it is refused.
  std::string source_id;
  uint64_t seed = 1;
  double time_scale = 1;  // 1–1000: every interval but the bail-out limit is divided by it
  // Time from one decision to the next, 1 ns to 100 days; what a decision learns is averaged over
  // it. Half of it doubles the noise and the cost, and finds a change twice as soon.
  uint64_t decision_interval_ns = 2'000'000'000;
  // Minimum time from an executed switch to the next one that the policy chooses, at most 100 days.
  // Some policies wait for less after a switch that was cheap. Bail-outs do not wait.
  uint64_t cooldown_ns = 40'000'000'000;
  // Frame time after a switch that is not learnt from, at most 100 days. A trial lasts for twice
  // that; with 0 there is none.
  uint64_t settling_ns = 2'000'000'000;
  // Frames/s, 0–1000: a scene whose best arm has fewer gets the verdict degraded. 0: no scene does.
  double fps_floor = 30;
  Mode mode = Mode::kAi;
  // Called with every decision as it is made, on the thread that drives the decider. It must not
  // call the decider.
  std::function<void(const DecisionEvent&)> on_decision = nullptr;
  // Called with every row of the audit log under the same rules. A row is a line of CSV without its
  // line end; EmbeddedDecider::AuditHeader() is the header. Null: no log is made.
  std::function<void(std::string_view row)> on_audit_row = nullptr;
};

class EmbeddedDecider {
 public:
  // Arms as in AdaptiveBroadPhase::arms() and arm_versions(). kInvalidArgument, kNotFound (no such
  // file), kDataLoss (broken priors: one line naming the record).
  static Result<std::unique_ptr<EmbeddedDecider>> Create(const EmbeddedOptions& options,
                                                         std::span<const std::string> arms,
                                                         std::span<const uint32_t> arm_versions,
                                                         uint64_t now_ns);
  ~EmbeddedDecider();

  // Returns the arm, of those that the priors know, that costs least by them, for
  // AdaptiveBroadPhase::Freeze. The same
  // priors give the same arm, whatever the machine, the time and the seed. Errors: those of Create,
  // and kNotFound (the priors have nothing of the project with these arms).
  static Result<std::string> ArmOfPriors(const EmbeddedOptions& options,
                                         std::span<const std::string> arms,
                                         std::span<const uint32_t> arm_versions);

  // Returns the header line of the audit log, without a line end.
  static std::string AuditHeader();

  // Takes frames and switch outcomes in the order in which they happened.
  void Observe(std::span<const FrameSample> frames, uint64_t now_ns);
  void Observe(const SwitchOutcome& outcome, uint64_t now_ns);
  // Takes the shadow lane's samples and the scene's descriptor. The next decision learns from both.
  void Observe(std::span<const ShadowSample> samples);
  void Observe(const SceneDescriptor& descriptor);
  void SetMode(Mode mode, uint32_t active_arm, uint64_t now_ns);

  // Makes the decision that is due, if any. The caller posts a returned command, which may be that
  // of an earlier bail-out, into the mailbox.
  std::optional<SwitchCommand> Poll(uint64_t now_ns);

  // Returns the settling time divided by the time scale, for AdaptiveBroadPhase::SetSettling.
  uint64_t settling_ns() const;
  std::vector<ArmBelief> beliefs() const;
  // Returns the verdict of the latest decision.
  SceneVerdict verdict() const;
  // Returns the latest decision, with its reasons; absent before the first.
  const std::optional<DecisionEvent>& last_decision() const;
  uint64_t decision_count() const;
  // Returns the number of sources (sessions) in the priors that it started from; with 0 it started
  // from Beta(1,1).
  uint64_t prior_source_count() const;
  // Returns the text of a priors file with all records that it was given and what it has learnt
  // since. Where it is imported, or given with other priors, each piece of evidence counts once,
  // however often it comes. Cost: linear in the number of records, some 400 bytes each.
  std::string ExportPriors() const;

 private:
  class Impl;
  friend struct StudyMaker;  // of the implementation
  explicit EmbeddedDecider(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake
