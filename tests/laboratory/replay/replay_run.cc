#include "tests/laboratory/replay/replay_run.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "engine_client/adaptive/descriptor_estimator.h"
#include "engine_client/adaptive/guards/trial_guard.h"
#include "engine_client/adaptive/switch_cost_meter.h"
#include "engine_client/decider/policy/diagnosis.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

// The real client (engine_client/telemetry) sends a batch after this time or after this many
// frames.
constexpr int64_t kBatchNs = 250'000'000;
constexpr size_t kBatchFrames = 30;

decision::SessionSetup SetupOf(const ReplayScene& scene, const ReplaySetup& setup) {
  return {.options = setup.options,
          .arms = scene.arms(),
          .priors = setup.priors,
          .regime_priors = setup.regime_priors,
          .seed = setup.seed,
          .active_arm = static_cast<uint32_t>(setup.seed % scene.arm_count())};
}

// Sums the times of each arm over the frames from one decision to the next.
class ArmTimes {
 public:
  explicit ArmTimes(size_t arm_count) : ns_(arm_count) {}

  void Add(size_t arm, double ns) { ns_[arm] += ns; }
  // Returns the arm's time ÷ the fastest arm's time, minus 1. If the fastest arm's time is 0, it
  // returns the arm's time in nanoseconds.
  double LossRatioOf(size_t arm) const {
    const double fastest_ns = *std::min_element(ns_.begin(), ns_.end());
    return fastest_ns > 0 ? ns_[arm] / fastest_ns - 1 : ns_[arm];
  }
  bool empty() const { return std::count(ns_.begin(), ns_.end(), 0.0) == std::ssize(ns_); }
  void Clear() { ns_.assign(ns_.size(), 0); }

 private:
  std::vector<double> ns_;
};

// Plays a game: simulates the client and its clock, and calls the real session.
class Game {
 public:
  Game(const ReplayScene& scene, const ReplaySetup& setup);
  ReplayResult Play();

 private:
  struct PendingSwitch {
    SwitchCommand command;
    int64_t ready_ns = 0;  // the switch is not executed in earlier frames
    bool warm = false;
  };

  void PlayFrame();
  void ExecuteSwitch();
  FrameSample NextFrame();
  void Account(const FrameSample& frame);
  void Load(FrameSample& frame);
  void Batch(const FrameSample& frame);
  void Flush();
  void TickUntil(int64_t now_ns);
  void Accept(const decision::Decision& decision, int64_t now_ns);
  void NoteStored(const decision::Decision& decision);
  void Meter(const FrameSample& frame);
  bool IsOverLimit(FrameSample frame);
  FrameSample StopTrial();
  void EndTrial(const FrameSample& frame);
  void SwitchBack(const TrialGuard::End& end);
  void ReportTrialEnd();
  void Report(const SwitchOutcome& outcome);
  void ObserveScene();
  void NoteArm();
  void NoteTimes();
  void Judge(const decision::Diagnosis& diagnosis);
  ReplayLane::Place place(int64_t now_ns) const {
    return {now_ns, search_ns_, game_frame_, trace_frame_, arm_};
  }
  ReplayResult Finish();

  const ReplayScene& scene_;
  const ReplaySetup& setup_;
  decision::DecisionSession session_;
  std::optional<ReplayLane> lane_;
  ReplayLoad load_;
  SwitchCostMeter meter_;
  ReplayResult result_;
  ArmTimes since_tick_;  // in the frames since the latest tick

  int64_t now_ns_ = 0;      // end of the latest frame
  uint64_t search_ns_ = 0;  // total search time of all frames
  uint32_t game_frame_ = 0;
  uint32_t trace_frame_ = 0;
  uint32_t arm_;
  uint32_t epoch_ = 0;
  bool starting_up_ = true;
  bool metering_ = false;
  std::optional<PendingSwitch> pending_;
  TrialGuard trial_;
  std::optional<TrialGuard::End> trial_end_;  // if set, pending_ is the switch back
  std::span<const double> slowdown_;  // factors of the next frames, while the structure is fresh
  uint32_t next_frame_flags_ = 0;
  std::vector<FrameSample> batch_;
  int64_t batch_begin_ns_ = 0;
};

Game::Game(const ReplayScene& scene, const ReplaySetup& setup)
    : scene_(scene),
      setup_(setup),
      session_(SetupOf(scene, setup), decision::StudyPolicies()),
      load_(setup.frame_load, setup.seed),
      meter_(static_cast<uint64_t>(session_.setup().options.settling_ns)),
      since_tick_(scene.arm_count()),
      arm_(session_.active_arm()) {
  const bool learns_from_lane = session_.policy_kind().uses_shadow;
  if (setup.shadow_lane.value_or(learns_from_lane)) {
    lane_.emplace(scene, setup.shadow, setup.lane_errors, setup.seed);
  }
  result_.active_ns.resize(scene.arm_count());
  result_.first_active_ns.resize(scene.arm_count());
  batch_.reserve(kBatchFrames);
}

ReplayResult Game::Play() {
  FrameOrder order(scene_, OffsetOfSeed(scene_, setup_.seed));
  NoteArm();
  for (; game_frame_ < scene_.frame_count(); ++game_frame_) {
    trace_frame_ = order.Next();
    if (game_frame_ == 0) TickUntil(0);
    PlayFrame();
  }
  Flush();
  return Finish();
}

void Game::PlayFrame() {
  if (pending_ && now_ns_ >= pending_->ready_ns) ExecuteSwitch();
  FrameSample frame = NextFrame();
  const bool is_stopped = IsOverLimit(frame);
  if (is_stopped) frame = StopTrial();
  Account(frame);
  NoteTimes();
  Load(frame);
  now_ns_ += static_cast<int64_t>(frame.frame_time_ns);
  search_ns_ += frame.detection_time_ns;
  TickUntil(now_ns_);
  Batch(frame);
  if (metering_) Meter(frame);
  if (!is_stopped) EndTrial(frame);
  if ((frame.flags & kFrameBailOut) != 0) {
    ++result_.bail_out_count;
    Flush();
    Accept(session_.ObserveBailOut(frame, now_ns_), now_ns_);
  }
  ObserveScene();
}

void Game::ExecuteSwitch() {
  const PendingSwitch pending = *std::exchange(pending_, std::nullopt);
  trial_.Begin(arm_, pending.command,
               2 * static_cast<uint64_t>(session_.setup().options.settling_ns), pending.warm);
  arm_ = pending.command.arm;
  ++epoch_;
  slowdown_ = scene_.slowdown(trace_frame_, arm_);
  if (pending.warm) slowdown_ = slowdown_.last(1);
  next_frame_flags_ = pending.warm ? 0 : uint32_t{kFrameRebuild};
  const auto unsettled = meter_.Begin(pending.command, epoch_, pending.warm);
  metering_ = true;
  if (unsettled) Report(*unsettled);
  ReportTrialEnd();
  ++result_.switch_counts[static_cast<size_t>(pending.command.reason)];
  if (!starting_up_) ++result_.after_start_up_switch_count;
  NoteArm();
}

FrameSample Game::NextFrame() {
  double detection_ns = scene_.detection_ns(trace_frame_, arm_);
  if (!slowdown_.empty()) {
    if (meter_.awaits_rebuild()) {
      // The trace has no build time, so the first frame's additional time is reported in its place.
      meter_.OnRebuild(static_cast<uint64_t>(detection_ns * std::max(slowdown_.front() - 1, 0.0)));
    }
    detection_ns *= slowdown_.front();
    slowdown_ = slowdown_.subspan(1);
  }
  if (lane_) detection_ns *= lane_->frame_ratio();
  FrameSample frame{.detection_time_ns = static_cast<uint64_t>(detection_ns),
                    .aabb_check_count = scene_.aabb_check_count(trace_frame_, arm_),
                    .native_bytes = scene_.native_bytes(trace_frame_, arm_),
                    .object_count = scene_.object_count(trace_frame_),
                    .arm = arm_,
                    .switch_epoch = epoch_,
                    .flags = std::exchange(next_frame_flags_, 0)};
  frame.frame_time_ns = frame.detection_time_ns + scene_.options().other_work_ns;
  return frame;
}

// Lengthens the frame by the other work that runs on the core at this time (FrameLoad).
void Game::Load(FrameSample& frame) {
  const double ratio = load_.RatioAt(now_ns_);
  for (uint64_t* ns : {&frame.detection_time_ns, &frame.frame_time_ns})
    *ns = static_cast<uint64_t>(static_cast<double>(*ns) * ratio);
  if (frame.frame_time_ns > static_cast<uint64_t>(setup_.options.bail_out_ns))
    frame.flags |= kFrameBailOut;
}

void Game::Account(const FrameSample& frame) {
  if (starting_up_ && now_ns_ >= kStartUpNs && !session_.exploring()) {
    starting_up_ = false;
    result_.start_up_frame_count = game_frame_;
  }
  if (!starting_up_) result_.after_start_up_ns += frame.frame_time_ns;
  if (now_ns_ < kOpeningNs) {
    result_.opening_frame_count = game_frame_ + 1;
    result_.opening_ns += frame.frame_time_ns;
  }
  result_.total_ns += frame.frame_time_ns;
  result_.active_ns[arm_] += frame.frame_time_ns;
}

void Game::Batch(const FrameSample& frame) {
  if (batch_.empty()) batch_begin_ns_ = now_ns_;
  batch_.push_back(frame);
  if (batch_.size() == kBatchFrames || now_ns_ - batch_begin_ns_ >= kBatchNs) Flush();
}

void Game::Flush() {
  session_.ObserveFrames(batch_);
  batch_.clear();
}

void Game::TickUntil(int64_t now_ns) {
  while (session_.next_tick_ns() <= now_ns) {
    const int64_t due_ns = session_.next_tick_ns();
    const decision::Decision decision = session_.Tick(due_ns);
    if (!result_.first_choice)
      result_.first_choice = decision.command ? decision.command->arm : arm_;
    Accept(decision, due_ns);
    ++result_.verdict_counts[static_cast<size_t>(session_.diagnosis().verdict)];
    Judge(session_.diagnosis());
    NoteArm();
  }
}

void Game::Accept(const decision::Decision& decision, int64_t now_ns) {
  if (setup_.on_decision) setup_.on_decision(decision.record);
  NoteStored(decision);
  if (!decision.command) return;
  if (decision.command->arm == arm_) {
    session_.ObserveRefusal(decision.command->command_id);
    return;
  }
  pending_ = PendingSwitch{.command = *decision.command, .ready_ns = now_ns};
  trial_end_.reset();
  // A switch after a bail-out does not wait for a warm-up.
  pending_->warm = lane_ && decision.command->reason != SwitchReason::kBailOut;
  if (pending_->warm) pending_->ready_ns = lane_->WarmUp(decision.command->arm, place(now_ns));
}

void Game::NoteStored(const decision::Decision& decision) {
  if (!decision.increment && decision.lane_increments.empty()) return;
  std::vector<decision::ArmEvidence>& arms = result_.stored[decision.regime];
  arms.resize(scene_.arm_count());
  const auto add = [](const decision::Increment& increment, decision::EvidenceSum& sum) {
    sum.alpha += increment.alpha;
    sum.beta += increment.beta;
  };
  if (decision.increment) {
    decision::ArmEvidence& arm = arms[decision.increment->arm];
    add(*decision.increment, arm.live);
    arm.bail_out_count += decision.increment->bail_out_count;
  }
  for (const decision::Increment& increment : decision.lane_increments)
    add(increment, arms[increment.arm].lane);
}

void Game::Meter(const FrameSample& frame) {
  FrameSample sample{};
  sample.frame_time_ns = frame.frame_time_ns;
  const auto outcome = meter_.OnFrame(sample);
  if (!outcome) return;
  metering_ = false;
  Report(*outcome);
}

// Returns whether a client stops the search of this frame, which is part of a trial.
bool Game::IsOverLimit(FrameSample frame) {
  const std::optional<uint64_t> limit_ns = trial_.limit_ns();
  if (!limit_ns) return false;
  Load(frame);
  return frame.detection_time_ns > *limit_ns;
}

// Ends a trial as a client does that stops its search at the limit. Returns the frame, which the
// previous arm then answers.
FrameSample Game::StopTrial() {
  const uint64_t limit_ns = *trial_.limit_ns();
  SwitchBack(trial_.Stop(limit_ns));
  ExecuteSwitch();
  FrameSample frame = NextFrame();
  const auto searched_ns =
      static_cast<uint64_t>(static_cast<double>(limit_ns) / load_.RatioAt(now_ns_));
  frame.detection_time_ns += searched_ns;
  frame.frame_time_ns += searched_ns;
  return frame;
}

// Ends a trial as a client does after a frame.
void Game::EndTrial(const FrameSample& frame) {
  FrameSample sample{};
  sample.frame_time_ns = frame.frame_time_ns;
  sample.detection_time_ns = frame.detection_time_ns;
  sample.arm = frame.arm;
  sample.flags = frame.flags & kFrameRebuild;
  if (const std::optional<TrialGuard::End> end = trial_.OnFrame(sample)) SwitchBack(*end);
}

// The switch costs no rebuild, because the previous arm still has its structure.
void Game::SwitchBack(const TrialGuard::End& end) {
  trial_end_ = end;
  pending_ = PendingSwitch{.command = {.arm = end.arm_before}, .ready_ns = now_ns_, .warm = true};
}

void Game::ReportTrialEnd() {
  const auto end = std::exchange(trial_end_, std::nullopt);
  if (!end) return;
  Report({.arm = arm_,
          .switch_epoch = epoch_,
          .executed = 1,
          .trial_detection_time_ns = end->detection_time_ns,
          .trial_arm = end->tried_arm});
}

void Game::Report(const SwitchOutcome& outcome) {
  Flush();
  session_.ObserveSwitch(outcome.arm, outcome.switch_epoch, outcome.reason, now_ns_,
                         decision::SwitchCostOf(outcome));
}

void Game::ObserveScene() {
  if (game_frame_ % DescriptorEstimator::kPeriodFrames == DescriptorEstimator::kPeriodFrames - 1) {
    if (const auto* descriptor = scene_.descriptor(trace_frame_)) {
      Flush();
      session_.ObserveDescriptor(*descriptor);
    }
  }
  while (lane_ && lane_->next_event_ns() <= now_ns_) {
    if (const auto sample = lane_->Advance(place(now_ns_))) session_.ObserveShadow({&*sample, 1});
  }
}

// Records the first time at which the policy chose the active arm. The exploration does not count,
// because it runs every arm.
void Game::NoteArm() {
  if (session_.exploring() || result_.first_active_ns[arm_]) return;
  result_.first_active_ns[arm_] = now_ns_;
}

void Game::NoteTimes() {
  for (uint32_t arm = 0; arm < scene_.arm_count(); ++arm)
    since_tick_.Add(arm, scene_.detection_ns(trace_frame_, arm));
}

// Adds the tick's P(best) to the reliability table, compared with the frames since the previous
// tick.
void Game::Judge(const decision::Diagnosis& diagnosis) {
  if (since_tick_.empty()) return;
  if (!diagnosis.best_probability.empty()) {
    result_.reliability.Add(diagnosis.best_probability[diagnosis.leader],
                            since_tick_.LossRatioOf(diagnosis.leader));
  }
  since_tick_.Clear();
}

ReplayResult Game::Finish() {
  if (starting_up_) result_.start_up_frame_count = scene_.frame_count();
  result_.observation = session_.observation(now_ns_);
  if (lane_) {
    result_.shadow_visit_count = lane_->visit_count();
    result_.shadow_ns = lane_->busy_ns();
  }
  return std::move(result_);
}

}  // namespace

void Reliability::Add(double probability, double loss_ratio) {
  const auto above = std::upper_bound(kEdges.begin() + 1, kEdges.end() - 1, probability);
  ReliabilityBin& bin = bins_[static_cast<size_t>(above - kEdges.begin()) - 1];
  ++bin.decision_count;
  bin.probability_sum += probability;
  if (loss_ratio <= 0) ++bin.best_count;
  if (loss_ratio <= decision::kTieLossRatio) ++bin.tie_count;
}

Reliability& Reliability::operator+=(const Reliability& other) {
  for (size_t i = 0; i < kBinCount; ++i) {
    bins_[i].decision_count += other.bins_[i].decision_count;
    bins_[i].probability_sum += other.bins_[i].probability_sum;
    bins_[i].best_count += other.bins_[i].best_count;
    bins_[i].tie_count += other.bins_[i].tie_count;
  }
  return *this;
}

uint64_t Reliability::decision_count() const {
  uint64_t count = 0;
  for (const ReliabilityBin& bin : bins_) count += bin.decision_count;
  return count;
}

double Reliability::error() const {
  double sum = 0;
  for (const ReliabilityBin& bin : bins_)
    sum += std::abs(bin.probability_sum - static_cast<double>(bin.best_count));
  return sum / static_cast<double>(std::max<uint64_t>(decision_count(), 1));
}

uint32_t ReplayResult::dominant_arm() const {
  const auto& active = observation.active_ns;
  return static_cast<uint32_t>(std::max_element(active.begin(), active.end()) - active.begin());
}

double ReplayResult::active_share() const {
  const auto& active = observation.active_ns;
  const uint64_t all_ns = std::accumulate(active.begin(), active.end(), uint64_t{0});
  return all_ns == 0 ? 0
                     : static_cast<double>(active[dominant_arm()]) / static_cast<double>(all_ns);
}

ReplayResult Replay(const ReplayScene& scene, const ReplaySetup& setup) {
  return Game(scene, setup).Play();
}

}  // namespace sweepstake::cli
