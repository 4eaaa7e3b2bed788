#include "engine_client/cli/trace_pass.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <numeric>

#include "engine_client/adaptive/descriptor_estimator.h"
#include "engine_client/cli/arm_pace.h"
#include "engine_client/cli/frame_block.h"
#include "engine_client/scene/sequential_random.h"
#include "sweepstake/broad_phase.h"

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

// What all arms share, as they do in a game: the boxes, and the buffer their pairs go into.
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

// The order in which the contestants of a block take turns.
class TurnOrder {
 public:
  // `twin` and the last contestant are kept apart.
  TurnOrder(size_t contestant_count, size_t twin, uint64_t seed)
      : order_(contestant_count), twin_(twin), random_(seed) {
    std::iota(order_.begin(), order_.end(), size_t{0});
  }

  const std::vector<size_t>& Next() {
    // Two contestants cannot be kept apart; more than that soon are.
    constexpr int kMostDraws = 64;
    const size_t last = order_.back();
    for (int draw = 0; draw < kMostDraws; ++draw) {
      Shuffle();
      if (!HasTwinsTogether(last)) break;
    }
    return order_;
  }

 private:
  void Shuffle() {
    for (size_t left = order_.size(); left > 1; --left) {
      std::swap(order_[left - 1], order_[random_.Below(left)]);
    }
  }
  bool HasTwinsTogether(size_t before) const {
    for (const size_t contestant : order_) {
      if (AreTwins(before, contestant)) return true;
      before = contestant;
    }
    return false;
  }
  bool AreTwins(size_t a, size_t b) const {
    const size_t control = order_.size() - 1;
    return (a == twin_ && b == control) || (a == control && b == twin_);
  }

  std::vector<size_t> order_;
  size_t twin_;
  SequentialRandom random_;
};

class TracePass {
 public:
  TracePass(Scene& scene, const TracePlan& plan)
      : scene_(scene),
        plan_(plan),
        pace_(plan.frame_ns),
        order_(plan.arms.size() + 1, plan.control_arm, plan.order_seed) {
    for (const std::string& name : plan.arms) structures_.push_back(MakeArm(name));
    structures_.push_back(MakeArm(plan.arms[plan.control_arm]));
    InitTrace();
  }

  Result<CostTrace> Run(const std::function<void(uint32_t)>& on_frame) {
    WarmUp();
    while (done_ < plan_.frame_count && status_.ok()) {
      block_.Fill(scene_, plan_.frame_count - done_);
      NoteFrames();
      const std::vector<ArmTurn> turns = Turns();
      for (const size_t contestant : order_.Next()) {
        Record(contestant, turns[ArmOf(contestant)], RunTurn(contestant, turns[ArmOf(contestant)]));
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
    for (const auto& structure : structures_) bench_.Build(*structure, scene_.aabbs());
    block_.Fill(scene_, kTraceWarmupFrames);
    for (const size_t contestant : order_.Next()) {
      RunTurn(contestant, pace_.TurnOf(ArmOf(contestant), ObjectCount()));
    }
  }

  // What the block shows, whoever looks at it.
  void NoteFrames() {
    for (size_t step = 0; step < block_.step_count(); ++step) {
      const uint32_t frame = done_ + static_cast<uint32_t>(step);
      trace_.object_count[frame] = static_cast<uint32_t>(block_.BoxesOf(step).size());
      trace_.step_ns[frame] = block_.step_ns(step);
      estimator_.Observe(block_.BoxesOf(step));
      if (estimator_.ready()) trace_.descriptors.push_back({frame + 1, estimator_.Take()});
    }
  }

  std::vector<ArmTurn> Turns() const {
    std::vector<ArmTurn> turns;
    for (size_t arm = 0; arm < arm_count(); ++arm) {
      turns.push_back(pace_.TurnOf(arm, ObjectCount()));
    }
    return turns;
  }

  // The costs of the block's last frames, as many as the turn measures.
  std::vector<FrameCost> RunTurn(size_t contestant, ArmTurn turn) {
    std::vector<FrameCost> costs;
    if (turn == ArmTurn::kNone) return costs;
    BroadPhase& structure = *structures_[contestant];
    const size_t count = block_.step_count();
    const size_t first = turn == ArmTurn::kEveryFrame || count < 2 ? 0 : count - 2;
    for (size_t step = first; step < count; ++step) {
      costs.push_back(bench_.Update(structure, block_.BoxesOf(step)));
    }
    if (turn == ArmTurn::kLastFrame) costs.erase(costs.begin(), costs.end() - 1);
    return costs;
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

  // Never called for the first block: no arm sits it out (arm_pace.h).
  void CopyLastFrame(uint32_t frame, size_t arm) {
    const size_t at = frame * arm_count() + arm;
    trace_.detection_ns[at] = trace_.detection_ns[at - arm_count()];
    trace_.aabb_check_count[at] = trace_.aabb_check_count[at - arm_count()];
    trace_.native_bytes[at] = trace_.native_bytes[at - arm_count()];
  }

  void NotePace(size_t arm, ArmTurn turn, const std::vector<FrameCost>& costs) {
    uint64_t sum = 0;
    for (const FrameCost& cost : costs) sum += cost.ns;
    // A sparse turn's other frame costs as much, or more.
    const uint64_t spent = turn == ArmTurn::kLastFrame ? 2 * sum : sum;
    pace_.Note(arm, turn, ObjectCount(), sum / costs.size(), spent);
  }

  void CheckPairs(uint32_t frame, size_t arm, uint32_t pair_count) {
    uint32_t& right = trace_.pair_count[frame];
    if (right == kPairsUnknown) right = pair_count;
    if (right == pair_count || !status_.ok()) return;
    status_ = {StatusCode::kInternal, plan_.arms[arm] + " finds " + std::to_string(pair_count) +
                                          " pairs in frame " + std::to_string(frame) +
                                          ", another arm " + std::to_string(right) +
                                          "; `sweepstake check` tells who is right"};
  }

  void RunBurst(const std::vector<ArmTurn>& turns) {
    TraceBurst burst{done_, std::vector<uint64_t>(arm_count() * kBurstFrames)};
    for (const size_t arm : order_.Next()) {
      if (arm == arm_count()) continue;
      const auto times = burst.detection_ns.begin() + static_cast<ptrdiff_t>(arm * kBurstFrames);
      if (turns[arm] == ArmTurn::kNone) {
        const auto& before = trace_.bursts.back().detection_ns;
        std::copy_n(before.begin() + static_cast<ptrdiff_t>(arm * kBurstFrames), kBurstFrames,
                    times);
      } else {
        const uint32_t count = turns[arm] == ArmTurn::kEveryFrame ? kBurstFrames : 2;
        RunFresh(plan_.arms[arm], count, std::span(&*times, kBurstFrames));
      }
    }
    trace_.bursts.push_back(std::move(burst));
  }

  // Times `count` frames; the last one's time stands for the others.
  void RunFresh(const std::string& name, uint32_t count, std::span<uint64_t> times) {
    const auto fresh = MakeArm(name);
    times[0] = bench_.Build(*fresh, block_.BoxesOf(0)).ns;
    for (uint32_t k = 1; k < count; ++k) times[k] = bench_.Update(*fresh, block_.BoxesOf(k)).ns;
    std::fill(times.begin() + count, times.end(), times[count - 1]);
  }

  Scene& scene_;
  const TracePlan& plan_;
  ArmPace pace_;
  TurnOrder order_;
  std::vector<std::unique_ptr<BroadPhase>> structures_;  // of the arms, then the control
  Bench bench_;
  FrameBlock block_;
  DescriptorEstimator estimator_;
  CostTrace trace_;
  uint32_t done_ = 0;  // frames of the blocks before this one
  uint32_t block_index_ = 0;
  Status status_;
};

}  // namespace

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
  std::vector<uint64_t> least;
  for (const auto& structure : structures) {
    uint64_t ns = std::numeric_limits<uint64_t>::max();
    for (size_t step = 0; step < block.step_count(); ++step) {
      ns = std::min(ns, bench.Update(*structure, block.BoxesOf(step)).ns);
    }
    least.push_back(ns);
  }
  return least;
}

Result<CostTrace> RunTracePass(Scene& scene, const TracePlan& plan,
                               const std::function<void(uint32_t)>& on_frame) {
  return TracePass(scene, plan).Run(on_frame);
}

}  // namespace sweepstake::cli
