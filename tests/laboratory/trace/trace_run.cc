#include "tests/laboratory/trace/trace_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "engine_client/adaptive/descriptor_estimator.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/machine_class.h"
#include "tests/laboratory/game/frame_block.h"

namespace sweepstake::cli {
namespace {

using std::chrono::steady_clock;

constexpr uint32_t kPairsUnknown = std::numeric_limits<uint32_t>::max();

struct FrameCost {
  uint64_t ns = 1;
  uint64_t aabb_check_count = 0;
  uint64_t native_bytes = 0;
  uint32_t pair_count = 0;
};

// Times a frame of an arm. All arms share the boxes and the pair buffer, as they do in a game.
class Bench {
 public:
  FrameCost Build(BroadPhase& arm, std::span<const Aabb> boxes) {
    return Time(arm, boxes, [&] { arm.Build(boxes_); });
  }
  FrameCost Update(BroadPhase& arm, std::span<const Aabb> boxes) {
    return Time(arm, boxes, [&] { arm.Update(boxes_); });
  }

 private:
  template <typename Take>
  FrameCost Time(BroadPhase& arm, std::span<const Aabb> boxes, const Take& take_boxes) {
    boxes_.assign(boxes.begin(), boxes.end());
    pairs_.Clear();
    const auto start = steady_clock::now();
    take_boxes();
    arm.FindPairs(pairs_);
    const auto ns = static_cast<uint64_t>((steady_clock::now() - start).count());
    return {std::max<uint64_t>(ns, 1), arm.aabb_check_count(), arm.native_bytes(),
            static_cast<uint32_t>(pairs_.size())};
  }

  std::vector<Aabb> boxes_;
  PairBuffer pairs_;
};

std::unique_ptr<BroadPhase> MakeArm(const std::string& name) {
  return std::move(*MakeBroadPhase(name));
}

class TracePass {
 public:
  TracePass(Scene& scene, const TracePlan& plan)
      : scene_(scene),
        plan_(plan),
        pace_(plan.frame_ns),
        order_(plan.arms.size() + 1, plan.control_arm, plan.order_seed) {
    structures_.resize(plan.arms.size() + 1);
    for (const size_t contestant : order_.Next()) {
      structures_[contestant] = MakeArm(plan.arms[ArmOf(contestant)]);
    }
    InitTrace();
  }

  Result<CostTrace> Run(const std::function<void(uint32_t)>& on_frame) {
    WarmUp();
    while (done_ < plan_.frame_count && status_.ok()) {
      block_.Fill(scene_, plan_.frame_count - done_);
      NoteFrames();
      const std::vector<ArmTurn> turns = Turns();
      RunBlock(turns);
      for (size_t contestant = 0; contestant <= arm_count(); ++contestant) {
        Record(contestant, turns[ArmOf(contestant)], costs_[contestant]);
      }
      if (block_index_++ % kBlocksPerBurst == 0 && block_.step_count() >= kBurstFrames) {
        RunBurst(turns);
      }
      done_ += static_cast<uint32_t>(block_.step_count());
      on_frame(done_);
    }
    if (!status_.ok()) return status_;
    return std::move(trace_);
  }

 private:
  size_t arm_count() const { return plan_.arms.size(); }
  size_t ArmOf(size_t contestant) const {
    return contestant == arm_count() ? plan_.control_arm : contestant;
  }
  size_t ObjectCount() const { return block_.BoxesOf(block_.step_count() - 1).size(); }

  void InitTrace() {
    for (size_t i = 0; i < arm_count(); ++i) {
      trace_.arms.push_back({plan_.arms[i], structures_[i]->version()});
    }
    trace_.frame_count = plan_.frame_count;
    trace_.control_arm = plan_.control_arm;
    trace_.burst_frame_count = kBurstFrames;
    const size_t frames = plan_.frame_count;
    trace_.object_count.resize(frames);
    trace_.pair_count.resize(frames, kPairsUnknown);
    trace_.step_ns.resize(frames);
    trace_.control_ns.resize(frames);
    trace_.detection_ns.resize(frames * arm_count());
    trace_.aabb_check_count.resize(frames * arm_count());
    trace_.native_bytes.resize(frames * arm_count());
    trace_.held.resize(frames * arm_count());
  }

  void WarmUp() {
    // The structures are built in a different order in every run, because a structure's place in
    // memory affects its times.
    for (const size_t contestant : order_.Next()) {
      bench_.Build(*structures_[contestant], scene_.aabbs());
    }
    block_.Fill(scene_, kTraceWarmupFrames);
    RunBlock(Turns());
  }

  // Records values of a block that do not depend on the arm: object counts, the scene's own time
  // and descriptors.
  void NoteFrames() {
    for (size_t step = 0; step < block_.step_count(); ++step) {
      const uint32_t frame = done_ + static_cast<uint32_t>(step);
      trace_.object_count[frame] = static_cast<uint32_t>(block_.BoxesOf(step).size());
      trace_.step_ns[frame] = block_.step_ns(step);
      Describe(frame, block_.BoxesOf(step));
    }
  }

  // Records each descriptor that is complete after this frame. The estimators start at different
  // frames, because a replayed game needs a recent descriptor at any frame.
  void Describe(uint32_t frame, std::span<const Aabb> boxes) {
    constexpr uint32_t kStep = DescriptorEstimator::kPeriodFrames / kEstimators;
    for (uint32_t i = 0; i < kEstimators; ++i) {
      if (frame < i * kStep) continue;
      estimators_[i].Observe(boxes);
      if (estimators_[i].ready()) trace_.descriptors.push_back({frame + 1, estimators_[i].Take()});
    }
  }

  std::vector<ArmTurn> Turns() const {
    std::vector<ArmTurn> turns;
    for (size_t arm = 0; arm < arm_count(); ++arm) {
      turns.push_back(pace_.TurnOf(arm, ObjectCount()));
    }
    turns[plan_.control_arm] = ArmTurn::kEveryFrame;
    return turns;
  }

  void RunBlock(const std::vector<ArmTurn>& turns) {
    costs_.assign(arm_count() + 1, {});
    for (size_t step = 0; step < block_.step_count(); ++step) {
      for (const size_t contestant : order_.Next()) {
        RunFrame(contestant, step, turns[ArmOf(contestant)]);
      }
    }
  }

  void RunFrame(size_t contestant, size_t step, ArmTurn turn) {
    const size_t last = block_.step_count() - 1;
    if (turn == ArmTurn::kNone || (turn == ArmTurn::kLastFrame && step + 1 < last)) return;
    const FrameCost cost = bench_.Update(*structures_[contestant], block_.BoxesOf(step));
    if (turn == ArmTurn::kEveryFrame || step == last) costs_[contestant].push_back(cost);
  }

  void Record(size_t contestant, ArmTurn turn, const std::vector<FrameCost>& costs) {
    const size_t held_count = block_.step_count() - costs.size();
    for (size_t step = 0; step < block_.step_count(); ++step) {
      const auto frame = static_cast<uint32_t>(done_ + step);
      if (contestant == arm_count()) {
        trace_.control_ns[frame] = costs[step].ns;
        continue;
      }
      const bool held = step < held_count;
      if (costs.empty()) {
        CopyLastFrame(frame, contestant);
      } else {
        Put(frame, contestant, held ? costs.front() : costs[step - held_count]);
        if (!held) CheckPairs(frame, contestant, costs[step - held_count].pair_count);
      }
      trace_.held[frame * arm_count() + contestant] = held ? 1 : 0;
    }
    if (contestant < arm_count() && !costs.empty()) NotePace(contestant, turn, costs);
  }

  void Put(uint32_t frame, size_t arm, const FrameCost& cost) {
    const size_t at = frame * arm_count() + arm;
    trace_.detection_ns[at] = cost.ns;
    trace_.aabb_check_count[at] = cost.aabb_check_count;
    trace_.native_bytes[at] = cost.native_bytes;
  }

  // Repeats the arm's values of the previous frame. Never called in the first block, in which every
  // arm is measured.
  void CopyLastFrame(uint32_t frame, size_t arm) {
    const size_t last = (frame - 1) * arm_count() + arm;
    Put(frame, arm,
        {trace_.detection_ns[last], trace_.aabb_check_count[last], trace_.native_bytes[last]});
  }

  void NotePace(size_t arm, ArmTurn turn, const std::vector<FrameCost>& costs) {
    std::vector<uint64_t> times;
    times.reserve(costs.size());
    for (const FrameCost& cost : costs) times.push_back(cost.ns);
    const uint64_t sum = std::accumulate(times.begin(), times.end(), uint64_t{0});
    // The median keeps a single disturbed frame from making an arm count as slow.
    const auto middle = times.begin() + static_cast<ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    // A sparse turn also runs an unmeasured frame. It costs at least as much as the measured one,
    // so the turn costs twice that.
    pace_.Note(arm, turn, ObjectCount(), *middle, turn == ArmTurn::kLastFrame ? 2 * sum : sum);
  }

  void CheckPairs(uint32_t frame, size_t arm, uint32_t pair_count) {
    uint32_t& expected = trace_.pair_count[frame];
    if (expected == kPairsUnknown) expected = pair_count;
    if (expected == pair_count || !status_.ok()) return;
    status_ = {StatusCode::kInternal, plan_.arms[arm] + " finds " + std::to_string(pair_count) +
                                          " pairs in frame " + std::to_string(frame) +
                                          ", another arm finds " + std::to_string(expected) +
                                          "; `sweepstake-lab check` shows which arm is wrong"};
  }

  void RunBurst(const std::vector<ArmTurn>& turns) {
    TraceBurst burst{done_, std::vector<uint64_t>(arm_count() * kBurstFrames)};
    std::vector<std::unique_ptr<BroadPhase>> fresh;
    for (const std::string& name : plan_.arms) fresh.push_back(MakeArm(name));
    for (size_t k = 0; k < kBurstFrames; ++k) {
      for (const size_t arm : order_.Next()) {
        if (arm < arm_count()) {
          burst.detection_ns[arm * kBurstFrames + k] =
              BurstFrame(*fresh[arm], arm, k, turns[arm], burst);
        }
      }
    }
    trace_.bursts.push_back(std::move(burst));
  }

  // Returns the time of the arm in frame k of the burst. A sparsely measured arm runs two frames,
  // and the time of the second one is used for all later frames. An arm that skips the block
  // repeats its times of the previous burst.
  uint64_t BurstFrame(BroadPhase& fresh, size_t arm, size_t k, ArmTurn turn,
                      const TraceBurst& burst) {
    const size_t at = arm * kBurstFrames + k;
    if (turn == ArmTurn::kNone) return trace_.bursts.back().detection_ns[at];
    if (turn == ArmTurn::kLastFrame && k > 1) return burst.detection_ns[at - 1];
    const auto boxes = block_.BoxesOf(k);
    return (k == 0 ? bench_.Build(fresh, boxes) : bench_.Update(fresh, boxes)).ns;
  }

  Scene& scene_;
  const TracePlan& plan_;
  ArmPace pace_;
  TurnOrder order_;
  std::vector<std::unique_ptr<BroadPhase>> structures_;  // one per arm, then the control's
  Bench bench_;
  FrameBlock block_;
  std::vector<std::vector<FrameCost>> costs_;  // per contestant, the block's measured frames
  // The estimators start at staggered frames, so that a descriptor of the latest frames is always
  // ready.
  static constexpr uint32_t kEstimators = 8;
  std::array<DescriptorEstimator, kEstimators> estimators_;
  CostTrace trace_;
  uint32_t done_ = 0;  // frames in the blocks before this one
  uint32_t block_index_ = 0;
  Status status_;
};

// Returns the lower quartile: the second of five values, the minimum of four or fewer.
uint64_t LowerQuartile(std::vector<uint64_t>& values) {
  const auto quartile = values.begin() + static_cast<ptrdiff_t>((values.size() - 1) / 4);
  std::nth_element(values.begin(), quartile, values.end());
  return *quartile;
}

// Replaces a column of the first run by the quartiles over all runs. `column` returns the column of
// a run.
void TakeQuartiles(std::vector<CostTrace>& runs,
                   const std::function<std::vector<uint64_t>&(CostTrace&)>& column) {
  std::vector<std::vector<uint64_t>*> columns;
  columns.reserve(runs.size());
  for (CostTrace& run : runs) columns.push_back(&column(run));
  std::vector<uint64_t> values(runs.size());
  for (size_t i = 0; i < columns.front()->size(); ++i) {
    for (size_t run = 0; run < columns.size(); ++run) values[run] = (*columns[run])[i];
    (*columns.front())[i] = LowerQuartile(values);
  }
}

void KeepHeldInAll(std::vector<CostTrace>& runs) {
  std::vector<uint8_t>& held = runs.front().held;
  for (const CostTrace& run : runs) {
    for (size_t i = 0; i < held.size(); ++i) held[i] = held[i] & run.held[i];
  }
}

Status TooManyObjects() {
  return {StatusCode::kInvalidArgument, "a trace has at most " + std::to_string(kMaxTracedObjects) +
                                            " objects per frame; use fewer --objects"};
}

// Opens the scene at its start. Error: it has too many objects.
Result<std::unique_ptr<Scene>> Open(const SceneChoice& choice) {
  auto scene = OpenScene(choice);
  if (scene.ok() && (*scene)->max_object_count() > kMaxTracedObjects) return TooManyObjects();
  return scene;
}

// Returns the approximate time of a frame for each arm: the minimum of a few frames. Steps the
// scene.
std::vector<uint64_t> ProbeArms(const std::vector<std::string>& arms, Scene& scene) {
  constexpr size_t kProbeFrames = 5;
  FrameBlock block;
  std::vector<std::unique_ptr<BroadPhase>> structures;
  Bench bench;
  for (const std::string& arm : arms) {
    structures.push_back(MakeArm(arm));
    bench.Build(*structures.back(), scene.aabbs());
  }
  block.Fill(scene, kProbeFrames);
  std::vector<uint64_t> min_ns;
  for (const auto& structure : structures) {
    uint64_t ns = std::numeric_limits<uint64_t>::max();
    for (size_t step = 0; step < block.step_count(); ++step) {
      ns = std::min(ns, bench.Update(*structure, block.BoxesOf(step)).ns);
    }
    min_ns.push_back(ns);
  }
  return min_ns;
}

// Returns a plan for all runs. order_seed is set later, because it differs from run to run.
Result<TracePlan> MakePlan(const TraceOptions& options) {
  auto scene = Open(options.scene);
  if (!scene.ok()) return scene.status();
  TracePlan plan;
  plan.arms = options.arms;
  plan.frame_count = options.frame_count;
  plan.frame_ns = ProbeArms(plan.arms, **scene);
  const auto cheapest = std::min_element(plan.frame_ns.begin(), plan.frame_ns.end());
  plan.control_arm = static_cast<uint32_t>(cheapest - plan.frame_ns.begin());
  return plan;
}

Result<CostTrace> RunOnce(const TraceOptions& options, const TracePlan& plan,
                          const std::function<void(uint32_t)>& on_frame) {
  auto scene = Open(options.scene);
  if (!scene.ok()) return scene.status();
  auto trace = RunTracePass(**scene, plan, on_frame);
  // A recorded scene may have too many objects in later frames only.
  if (trace.ok() && trace->bursts.empty()) return TooManyObjects();
  return trace;
}

}  // namespace

Result<CostTrace> RunTracePass(Scene& scene, const TracePlan& plan,
                               const std::function<void(uint32_t)>& on_frame) {
  return TracePass(scene, plan).Run(on_frame);
}

CostTrace MergeRuns(std::vector<CostTrace> runs) {
  for (const auto column : {&CostTrace::step_ns, &CostTrace::control_ns, &CostTrace::detection_ns})
    TakeQuartiles(runs, std::mem_fn(column));
  for (size_t i = 0; i < runs.front().bursts.size(); ++i) {
    TakeQuartiles(
        runs, [i](CostTrace & run) -> auto& { return run.bursts[i].detection_ns; });
  }
  KeepHeldInAll(runs);
  return std::move(runs.front());
}

Result<CostTrace> RunTrace(const TraceOptions& options,
                           const std::function<void(double)>& on_progress) {
  auto plan = MakePlan(options);
  if (!plan.ok()) return plan.status();
  std::vector<CostTrace> runs;
  const double all = static_cast<double>(options.frame_count) * options.repeat_count;
  while (runs.size() < options.repeat_count) {
    plan->order_seed = options.scene.seed * options.repeat_count + runs.size();
    const double before =
        static_cast<double>(options.frame_count) * static_cast<double>(runs.size());
    auto run = RunOnce(options, *plan,
                       [&](uint32_t frames_done) { on_progress((before + frames_done) / all); });
    if (!run.ok()) return run.status();
    runs.push_back(std::move(*run));
  }
  CostTrace trace = MergeRuns(std::move(runs));
  trace.scene = std::filesystem::path(options.scene.name).filename().string();
  trace.seed = options.scene.seed;
  trace.machine = MachineClass();
  trace.repeat_count = options.repeat_count;
  return trace;
}

}  // namespace sweepstake::cli
