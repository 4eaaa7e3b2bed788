#include "tests/laboratory/experiment/experiment_run.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/process.h"
#include "engine_client/decider/options.h"
#include "engine_client/telemetry/common/study_session.h"
#include "sweepstake/session.h"
#include "tests/laboratory/game/busy_scene.h"
#include "tests/laboratory/game/machine.h"
#include "tests/laboratory/policies/study_policies.h"
#include "tests/laboratory/trace/cost_trace.h"
#include "tests/laboratory/trace/trace_run.h"

namespace sweepstake::cli {
namespace {

constexpr uint32_t kStopDeadlineMs = 2000;
constexpr uint64_t kGoOnIntervalNs = 2'000'000;
// The queue holds the frames of 0.16 s if a frame takes 10 µs. The sender thread can wait that long
// for a processor core before frames are dropped.
constexpr uint32_t kQueueFrames = 16'384;

// A control run shows the frame time of each arm without decisions. The arms take turns in
// kControlRounds rounds of one block per arm. A block lasts for 1/kBlocksPerWindow of the window.
// If a block then has fewer than kBlockFrames frames (two turns of rotating gravity), it is
// extended to at most kBlockPatience times this length. The first fifth of each block is warm-up.
constexpr uint64_t kControlRounds = 2;
constexpr uint64_t kBlocksPerWindow = 210;  // 7 arms × 2 rounds take a fifteenth of the window
constexpr uint64_t kBlockFrames = 360;
constexpr uint64_t kBlockPatience = 10;

RecordedDecision Recorded(const DecisionEvent& event, uint64_t begin_ns) {
  RecordedDecision kept;
  kept.time_s = Seconds(event.time_ns - begin_ns);
  kept.active_arm = event.active_arm;
  if (event.candidate_arm) kept.candidate = *event.candidate_arm;
  kept.outcome = static_cast<uint32_t>(event.outcome);
  if (event.command) kept.reason = static_cast<uint32_t>(event.command->reason);
  if (event.reward) kept.reward = *event.reward;
  kept.leader = event.verdict.leader_arm;
  kept.expected_loss_ratio = event.expected_loss_ratio;
  kept.verdict = static_cast<uint32_t>(event.verdict.verdict);
  for (const ArmBelief& belief : event.beliefs) {
    kept.alpha.push_back(belief.alpha);
    kept.beta.push_back(belief.beta);
  }
  kept.best_probability = event.best_probability;
  return kept;
}

// Records the decisions. They arrive on the sender thread and are read after the session has
// stopped. The observation window begins with the decision that ends the exploration. Without an
// exploration it begins with the run.
class DecisionRecorder {
 public:
  static constexpr uint64_t kNotYet = ~uint64_t{0};

  void Add(const DecisionEvent& event) {
    const bool exploring = event.outcome == DecisionOutcome::kExploring;
    if (!exploring && observed_from_ns() == kNotYet) {
      const bool never_explored = decisions_.empty();
      observed_from_ns_.store(never_explored ? 0 : event.time_ns, std::memory_order_relaxed);
    }
    decisions_.push_back(event);
  }

  // Time at which the observation window began, on the decisions' clock; 0: at the run's start.
  uint64_t observed_from_ns() const { return observed_from_ns_.load(std::memory_order_relaxed); }
  const std::vector<DecisionEvent>& decisions() const { return decisions_; }

 private:
  std::atomic<uint64_t> observed_from_ns_{kNotYet};
  std::vector<DecisionEvent> decisions_;
};

std::vector<ArmActivity> Difference(std::vector<ArmActivity> later,
                                    const std::vector<ArmActivity>& earlier) {
  for (size_t arm = 0; arm < later.size(); ++arm) {
    later[arm].frame_count -= earlier[arm].frame_count;
    later[arm].active_ns -= earlier[arm].active_ns;
    later[arm].detection_ns -= earlier[arm].detection_ns;
  }
  return later;
}

std::vector<RecordedSwitch> Switches(const GameRun& run) {
  std::vector<RecordedSwitch> switches;
  for (const SwitchEvent& event : run.switches()) {
    RecordedSwitch kept{Seconds(event.time_ns), event.frame_index, event.from, event.to,
                        static_cast<uint32_t>(event.reason)};
    const SwitchOutcome outcome = OutcomeOf(run.outcomes(), event.switch_epoch);
    kept.rebuild_ns = outcome.rebuild_time_ns;
    kept.settling_ns = outcome.settling_cost_ns;
    switches.push_back(kept);
  }
  return switches;
}

class LiveRun {
 public:
  LiveRun(const PlannedRun& planned, const LiveOptions& options)
      : options_(options),
        decisions_(options.decision.Scaled(options.time_scale)),
        meter_(static_cast<uint64_t>(decisions_.decision_interval_ns)) {
    static_cast<PlannedRun&>(record_) = planned;
    record_.time_scale = options.time_scale;
  }

  Status Prepare();
  // Returns true if the run finished and false if it was stopped.
  Result<bool> Play();
  RunRecord Take() { return std::move(record_); }

 private:
  bool MayGoOn(uint64_t now_ns);
  Result<bool> Observe();
  uint64_t MaxExplorationNs() const;
  void Keep(uint64_t end_ns);
  bool Control();
  bool ControlBlock(uint32_t arm);

  const LiveOptions& options_;
  const decision::DecisionOptions decisions_;
  MetricWindowMeter meter_;
  RunRecord record_;
  DecisionRecorder decision_recorder_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<GameRun> run_;
  uint64_t begin_ns_ = 0;  // the run's start, on the steady clock
  uint64_t next_check_ns_ = 0;
};

Status LiveRun::Prepare() {
  auto scene = OpenScene({record_.cell.scene, record_.cell.object_count, record_.scene_seed});
  if (!scene.ok()) return scene.status();
  scene_ = std::make_unique<BusyScene>(std::move(*scene), options_.other_work_ns);
  SessionOptions options;
  options.queue_frames = kQueueFrames;
  EmbeddedOptions embedded;
  embedded.policy = record_.policy;
  embedded.seed = record_.seed;
  embedded.time_scale = options_.time_scale;
  embedded.decision_interval_ns = static_cast<uint64_t>(options_.decision.decision_interval_ns);
  embedded.cooldown_ns = static_cast<uint64_t>(options_.decision.cooldown_ns);
  embedded.settling_ns = static_cast<uint64_t>(options_.decision.settling_ns);
  embedded.on_decision = [this](const DecisionEvent& event) { decision_recorder_.Add(event); };
  embedded.weights = options_.decision.weights;
  auto session = MakeStudySession({decision::StudyPolicies()}, embedded, options);
  if (!session.ok()) return session.status();
  session_ = std::move(*session);
  AdaptiveOptions adaptive;
  adaptive.initial_arm = BroadPhaseNames()[record_.initial_arm];
  // Policies that learn from live frames only, such as the paper's, have no lane and switch cold.
  const bool learns_from_lane =
      decision::PolicyKindOf(record_.policy, decision::StudyPolicies()).uses_shadow;
  adaptive.shadow =
      ScaledShadow(learns_from_lane ? ShadowMode::kAuto : ShadowMode::kOff, options_.time_scale);
  auto run = GameRun::Create(adaptive, *scene_, session_->sink());
  if (!run.ok()) return run.status();
  run_ = std::move(*run);
  begin_ns_ = SteadyClock().NowNs() - run_->elapsed_ns();
  const auto arms = run_->adaptive().arms();
  record_.arms.assign(arms.begin(), arms.end());
  record_.start_utc = DescribeMachine().date_utc;
  return {};
}

Result<bool> LiveRun::Play() {
  if (Status status = session_->Start(run_->adaptive()); !status.ok()) return status;
  auto observed = Observe();
  session_->Stop(kStopDeadlineMs);
  if (!observed.ok() || !*observed) return observed;
  Keep(run_->elapsed_ns());
  return Control();
}

bool LiveRun::MayGoOn(uint64_t now_ns) {
  if (now_ns < next_check_ns_) return true;
  next_check_ns_ = now_ns + kGoOnIntervalNs;
  return options_.go_on(now_ns);
}

uint64_t LiveRun::MaxExplorationNs() const {
  constexpr uint64_t kPatience = 10;
  constexpr uint64_t kMinNs = 60'000'000'000;  // slow arms need it at a large time scale
  const auto slot_ns =
      static_cast<uint64_t>(decisions_.exploration_warm_up_ns + decisions_.exploration_measure_ns);
  return std::max(kMinNs, kPatience * slot_ns * record_.arms.size());
}

// Runs frames until the observation window has passed. Returns false if it was stopped.
Result<bool> LiveRun::Observe() {
  std::optional<uint64_t> end_ns;  // the window's end, since the run began; absent if not yet known
  for (uint64_t now_ns = 0; !end_ns || now_ns < *end_ns;) {
    run_->Frame();
    now_ns = run_->elapsed_ns();
    const FrameSample& sample = run_->adaptive().last_sample();
    meter_.Add(sample, now_ns);
    if (!MayGoOn(now_ns)) return false;
    if (end_ns) continue;
    if (const uint64_t from_ns = decision_recorder_.observed_from_ns();
        from_ns != DecisionRecorder::kNotYet) {
      const uint64_t since_begin_ns = from_ns == 0 ? 0 : from_ns - begin_ns_;
      record_.exploration_s = Seconds(since_begin_ns);
      record_.explored = run_->activities();
      if (from_ns == 0) record_.explored.assign(record_.arms.size(), {});
      end_ns = since_begin_ns + options_.window_ns;
    } else if (now_ns > MaxExplorationNs()) {
      return Status(StatusCode::kInternal, "the exploration of " + record_.label() +
                                               " does not end; try a smaller --time-scale");
    }
  }
  return true;
}

void LiveRun::Keep(uint64_t end_ns) {
  record_.end_s = Seconds(end_ns);
  record_.observed = Difference(run_->activities(), record_.explored);
  record_.switches = Switches(*run_);
  record_.windows = meter_.Take(end_ns);
  for (const DecisionEvent& each : decision_recorder_.decisions()) {
    record_.decisions.push_back(Recorded(each, begin_ns_));
  }
  const FrameProfile& frames = run_->profile();
  const SessionStats stats = session_->stats();
  const ShadowStats lane = run_->adaptive().shadow_stats();
  record_.time = {.scene_step_ns = frames.step_ns,
                  .detection_ns = frames.detection_ns,
                  .rebuild_ns = frames.rebuild_ns,
                  .copying_ns = std::min(lane.copy_time_ns, frames.around_ns),
                  .around_ns = frames.around_ns - std::min(lane.copy_time_ns, frames.around_ns),
                  .frame_end_ns = frames.end_ns,
                  .intake_ns = stats.intake_time_ns,
                  .decision_ns = stats.decision_time_ns,
                  .longest_decision_ns = stats.longest_decision_ns,
                  .lane_ns = lane.busy_time_ns};
  record_.shadow_visit_count = lane.visit_count;
  record_.warm_switch_count = lane.warm_switch_count;
  record_.dropped_frame_count = stats.dropped_frame_count;
}

bool LiveRun::Control() {
  run_->adaptive().SetMode(Mode::kManual);
  record_.controls.resize(record_.arms.size());
  for (uint64_t round = 0; round < kControlRounds; ++round) {
    for (uint32_t arm = 0; arm < record_.arms.size(); ++arm) {
      if (!ControlBlock(arm)) return false;
    }
  }
  return true;
}

bool LiveRun::ControlBlock(uint32_t arm) {
  ArmActivity& sum = record_.controls[arm];
  if (!run_->adaptive().SelectArm(record_.arms[arm]).ok()) return false;
  const uint64_t start_ns = run_->elapsed_ns();
  const uint64_t block_ns = options_.window_ns / kBlocksPerWindow;
  uint64_t passed_ns = 0;
  for (uint64_t frame = 0; passed_ns < block_ns || frame < kBlockFrames; ++frame) {
    run_->Frame();
    const uint64_t now_ns = run_->elapsed_ns();
    if (!MayGoOn(now_ns)) return false;
    passed_ns = now_ns - start_ns;
    const FrameSample& sample = run_->adaptive().last_sample();
    const bool warm = 5 * passed_ns > block_ns && (sample.flags & kFrameRebuild) == 0;
    if (warm) {
      ++sum.frame_count;
      sum.active_ns += sample.frame_time_ns;
      sum.detection_ns += sample.detection_time_ns;
    }
    if (sum.frame_count > 0 && passed_ns > kBlockPatience * block_ns) break;
  }
  return true;
}

// Returns the finished share if `done` of `all` parts are complete and `share` of the next one is.
double Share(size_t done, size_t all, double share) {
  return (static_cast<double>(done) + share) / static_cast<double>(all);
}

// Returns whether the trace is of this scene and was made with this experiment's options. If not,
// the scene is traced again.
bool IsTraceOf(const Result<CostTrace>& trace, const ExperimentPlan& plan,
               const PlannedScene& scene) {
  return trace.ok() && trace->frame_count == plan.options.trace_frame_count &&
         trace->seed == scene.seed;
}

TraceOptions OptionsOf(const ExperimentPlan& plan, const PlannedScene& scene) {
  TraceOptions options;
  options.scene = {scene.cell.scene, scene.cell.object_count, scene.seed};
  options.arms = *ChooseArms({"all"});
  options.frame_count = plan.options.trace_frame_count;
  return options;
}

// Returns the traces of the cell's scenes; empty if one is missing.
std::vector<CostTrace> TracesOf(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                const ExperimentCell& cell) {
  std::vector<CostTrace> traces;
  for (const PlannedScene& scene : plan.scenes) {
    if (scene.cell != cell) continue;
    auto trace = ReadCosts(folder.TraceFile(scene));
    if (!IsTraceOf(trace, plan, scene)) return {};
    traces.push_back(std::move(*trace));
  }
  return traces;
}

std::vector<const CellSummary*> CellsOf(std::span<const CellSummary> summaries,
                                        const ExperimentCell& cell) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& summary : summaries) {
    if (summary.cell == cell) cells.push_back(&summary);
  }
  return cells;
}

}  // namespace

void MetricWindowMeter::Add(const FrameSample& sample, uint64_t now_ns) {
  if (sums_.frame_count > 0 && (sample.arm != sums_.arm || now_ns - begin_ns_ >= interval_ns_)) {
    Close(now_ns);
  }
  const double frame_us = static_cast<double>(sample.frame_time_ns) * 1e-3;
  ++sums_.frame_count;
  sums_.arm = sample.arm;
  sums_.object_count = sample.object_count;
  sums_.frame_us_mean += frame_us;
  sums_.frame_us_max = std::max(sums_.frame_us_max, frame_us);
  sums_.detection_us_mean += static_cast<double>(sample.detection_time_ns) * 1e-3;
  sums_.check_count_mean += static_cast<double>(sample.aabb_check_count);
  sums_.pair_count_mean += static_cast<double>(sample.pair_count);
  sums_.native_bytes_max = std::max(sums_.native_bytes_max, sample.native_bytes);
}

std::vector<MetricWindow> MetricWindowMeter::Take(uint64_t now_ns) {
  if (sums_.frame_count > 0) Close(now_ns);
  return std::exchange(windows_, {});
}

void MetricWindowMeter::Close(uint64_t now_ns) {
  const double count = static_cast<double>(sums_.frame_count);
  sums_.time_s = static_cast<double>(now_ns) * 1e-9;
  sums_.frame_us_mean /= count;
  sums_.detection_us_mean /= count;
  sums_.check_count_mean /= count;
  sums_.pair_count_mean /= count;
  windows_.push_back(sums_);
  sums_ = {};
  begin_ns_ = now_ns;
}

Result<std::optional<RunRecord>> PlayLive(const PlannedRun& planned, const LiveOptions& options) {
  LiveRun live(planned, options);
  if (Status status = live.Prepare(); !status.ok()) return status;
  const auto played = live.Play();
  if (!played.ok()) return played.status();
  if (!*played) return std::optional<RunRecord>();
  return std::optional(live.Take());
}

Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder,
                  const ExperimentProgress& on_progress) {
  for (size_t i = 0; i < plan.scenes.size() && !StopRequested(); ++i) {
    const PlannedScene& scene = plan.scenes[i];
    if (IsTraceOf(ReadCosts(folder.TraceFile(scene)), plan, scene)) continue;
    const auto trace = RunTrace(OptionsOf(plan, scene), [&](double share) {
      on_progress(Share(i, plan.scenes.size(), share), scene.label());
    });
    if (!trace.ok()) return trace.status();
    if (Status status = WriteCosts(folder.TraceFile(scene), *trace); !status.ok()) return status;
  }
  return {};
}

Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder,
                const ExperimentProgress& on_progress) {
  const std::vector<RunRecord> there = folder.ReadRecords(plan);
  std::vector<PlannedRun> missing = plan.runs;
  std::erase_if(missing, [&](const PlannedRun& run) {
    return std::find(there.begin(), there.end(), run) != there.end();
  });
  // The control runs take a fifteenth of the window (kBlocksPerWindow).
  const auto run_ns = static_cast<double>(plan.window_ns + plan.window_ns / 15);
  for (size_t done = 0; done < missing.size() && !StopRequested(); ++done) {
    const PlannedRun& run = missing[done];
    const std::string text = "run " + std::to_string(done + 1) + " of " +
                             std::to_string(missing.size()) + ": " + run.label();
    const auto go_on = [&](uint64_t elapsed_ns) {
      const double of_run = std::min(1.0, static_cast<double>(elapsed_ns) / run_ns);
      on_progress((static_cast<double>(done) + of_run) / static_cast<double>(missing.size()), text);
      return !StopRequested();
    };
    const auto record = PlayLive(run, {plan.window_ns, plan.options.time_scale,
                                       plan.options.decision, plan.other_work_ns, go_on});
    if (!record.ok()) return record.status();
    if (!*record) return {};
    if (Status status = WriteRecord(**record, folder.RunFile(run)); !status.ok()) return status;
  }
  return {};
}

Result<ExperimentTruths> Assess(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                std::span<const CellSummary> cells,
                                const ExperimentProgress& on_progress) {
  TruthOptions options;
  options.seed_count = plan.options.replay_seed_count;
  options.thread_count = std::max(1U, std::thread::hardware_concurrency());
  options.time_scale = plan.options.time_scale;
  options.decision = plan.options.decision;
  ExperimentTruths truths;
  for (size_t i = 0; i < plan.cells.size(); ++i) {
    const ExperimentCell& cell = plan.cells[i];
    const std::vector<CostTrace> traces = TracesOf(plan, folder, cell);
    if (traces.empty()) continue;
    truths.cells.push_back(RankArms(cell, traces));
    if (StopRequested()) continue;
    const auto done = [&](double share) {
      on_progress(Share(i, plan.cells.size(), share), cell.label());
    };
    Status status = AssessCell(traces, CellsOf(cells, cell), options, done, truths.cells.back());
    if (!status.ok()) return status;
  }
  truths.over_cells = CompareOverCells(truths.cells);
  return truths;
}

}  // namespace sweepstake::cli
