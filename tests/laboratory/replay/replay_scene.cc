#include "tests/laboratory/replay/replay_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/cli/io/statistics.h"
#include "engine_client/math/hash.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kMaxGameFrames = 100'000'000;

Status Check(const CostTrace& trace) {
  if (trace.arms.size() > decision::kMaxArms) {
    return {StatusCode::kInvalidArgument,
            "the trace of '" + trace.scene + "' has " + std::to_string(trace.arms.size()) +
                " arms; a session has at most " + std::to_string(decision::kMaxArms)};
  }
  return {};
}

Status Check(const GameOptions& options) {
  const auto refused = [](const std::string& problem) {
    return Status(StatusCode::kInvalidArgument, problem);
  };
  if (options.frame_ns == 0 || options.other_work_ns >= options.frame_ns) {
    return refused("the other work fills the whole frame");
  }
  if (options.run_ns < options.frame_ns) {
    return refused("the run is shorter than a frame; make --run longer");
  }
  if (options.run_ns / options.frame_ns > kMaxGameFrames) {
    return refused("the run has " + std::to_string(options.run_ns / options.frame_ns) +
                   " frames; make --run shorter, for at most " + std::to_string(kMaxGameFrames));
  }
  return {};
}

std::vector<double> MeanDetection(const CostTrace& trace) {
  std::vector<double> means(trace.arms.size());
  for (size_t cell = 0; cell < trace.detection_ns.size(); ++cell) {
    means[cell % means.size()] += static_cast<double>(trace.detection_ns[cell]);
  }
  for (double& mean : means) mean /= static_cast<double>(trace.frame_count);
  return means;
}

double ControlRegret(const CostTrace& trace, double twin_mean_ns) {
  double sum_ns = 0;
  for (const uint64_t ns : trace.control_ns) sum_ns += static_cast<double>(ns);
  return sum_ns / static_cast<double>(trace.frame_count) / twin_mean_ns - 1;
}

// Returns the median time of a running structure of `arm` in frames first … last of the burst.
double RunningNs(const CostTrace& trace, const TraceBurst& burst, uint32_t arm, uint32_t first,
                 uint32_t last) {
  std::vector<double> running_ns;
  for (uint32_t k = first; k <= last; ++k) {
    const uint32_t frame = std::min(burst.first_frame + k, trace.frame_count - 1);
    running_ns.push_back(static_cast<double>(trace.detection(frame, arm)));
  }
  return Median(std::move(running_ns));
}

// Returns, for each frame of the burst, the time of a fresh structure of `arm` ÷ time of the
// running one. The frames of the warm-up are compared with the median of the frames around them,
// and the later frames share one ratio of medians, because a single disturbed frame would make its
// own ratio useless.
std::vector<double> SlowdownOf(const CostTrace& trace, const TraceBurst& burst, uint32_t arm) {
  constexpr uint32_t kUnsettled = 1 + kShadowWarmUpFrames;
  const uint32_t count = trace.burst_frame_count;
  const uint64_t* begin = burst.detection_ns.data() + size_t{arm} * count;
  const std::vector<double> fresh_ns(begin, begin + count);
  std::vector<double> slowdown;
  for (uint32_t k = 0; k < std::min(count, kUnsettled); ++k) {
    const uint32_t last = std::min(k + 1, count - 1);
    slowdown.push_back(fresh_ns[k] / RunningNs(trace, burst, arm, k > 0 ? k - 1 : 0, last));
  }
  if (count <= kUnsettled) return slowdown;
  const double settled = Median({fresh_ns.begin() + kUnsettled, fresh_ns.end()}) /
                         RunningNs(trace, burst, arm, kUnsettled, count - 1);
  slowdown.resize(count, settled);
  return slowdown;
}

}  // namespace

Result<ReplayScene> ReplayScene::Create(const CostTrace& trace, const GameOptions& options) {
  if (Status status = Check(options); !status.ok()) return status;
  if (Status status = Check(trace); !status.ok()) return status;
  const std::vector<double> means = MeanDetection(trace);
  const double best_ns = *std::min_element(means.begin(), means.end());
  ReplayScene scene;
  scene.options_ = options;
  if (scene.options_.pass_ns == 0) scene.options_.pass_ns = options.run_ns;
  scene.frame_count_ = static_cast<uint32_t>(options.run_ns / options.frame_ns);
  scene.control_regret_ = ControlRegret(trace, means[trace.control_arm]);
  for (const TracedArm& arm : trace.arms) scene.arms_.push_back(arm.name);
  scene.TakeFrames(trace, static_cast<double>(options.frame_ns - options.other_work_ns) / best_ns);
  return scene;
}

void ReplayScene::TakeFrames(const CostTrace& trace, double scale) {
  time_ratio_ = scale;
  trace_frame_count_ = trace.frame_count;
  detection_ns_.assign(trace.detection_ns.begin(), trace.detection_ns.end());
  for (double& ns : detection_ns_) ns *= scale;
  aabb_check_count_ = trace.aabb_check_count;
  native_bytes_ = trace.native_bytes;
  object_count_ = trace.object_count;
  TakeBursts(trace);
  TakeDescriptors(trace);
}

void ReplayScene::TakeBursts(const CostTrace& trace) {
  burst_frame_count_ = trace.burst_frame_count;
  for (const TraceBurst& burst : trace.bursts) {
    std::vector<double>& all = slowdown_.emplace_back();
    for (uint32_t arm = 0; arm < arm_count(); ++arm) {
      const std::vector<double> slowdown = SlowdownOf(trace, burst, arm);
      all.insert(all.end(), slowdown.begin(), slowdown.end());
    }
  }
  FindNearestBursts(trace);
}

void ReplayScene::FindNearestBursts(const CostTrace& trace) {
  const auto distance = [](uint32_t a, uint32_t b) { return a > b ? a - b : b - a; };
  uint32_t nearest = 0;
  for (uint32_t frame = 0; frame < trace_frame_count_; ++frame) {
    while (nearest + 1 < trace.bursts.size() &&
           distance(trace.bursts[nearest + 1].first_frame, frame) <=
               distance(trace.bursts[nearest].first_frame, frame)) {
      ++nearest;
    }
    nearest_burst_.push_back(nearest);
  }
}

void ReplayScene::TakeDescriptors(const CostTrace& trace) {
  for (const TracedDescriptor& traced : trace.descriptors)
    descriptors_.push_back(traced.descriptor);
  if (descriptors_.empty()) return;
  uint32_t latest = 0;
  for (uint32_t frame = 0; frame < trace_frame_count_; ++frame) {
    while (latest + 1 < descriptors_.size() && trace.descriptors[latest + 1].frame <= frame) {
      ++latest;
    }
    latest_descriptor_.push_back(latest);
  }
}

ReplayScene ReplayScene::WithArmRatios(std::span<const double> ratios) const {
  ReplayScene scene = *this;
  for (size_t i = 0; i < scene.detection_ns_.size(); ++i)
    scene.detection_ns_[i] *= ratios[i % ratios.size()];
  return scene;
}

double ReplayScene::mean_object_count() const {
  const uint64_t sum = std::accumulate(object_count_.begin(), object_count_.end(), uint64_t{0});
  return static_cast<double>(sum) / trace_frame_count_;
}

const SceneDescriptor* ReplayScene::descriptor(uint32_t trace_frame) const {
  return latest_descriptor_.empty() ? nullptr : &descriptors_[latest_descriptor_[trace_frame]];
}

FrameOrder::FrameOrder(const ReplayScene& scene, uint32_t offset)
    : trace_frame_count_(scene.trace_frame_count()),
      window_(std::min(ReplayScene::kWindowFrameCount, trace_frame_count_)),
      trace_frames_per_game_frame_(static_cast<double>(trace_frame_count_) *
                                   static_cast<double>(scene.options().frame_ns) /
                                   static_cast<double>(scene.options().pass_ns)),
      begin_(offset) {}

uint32_t FrameOrder::Next() {
  const uint32_t frame = static_cast<uint32_t>(begin_) + in_window_;
  begin_ += trace_frames_per_game_frame_;
  while (begin_ >= trace_frame_count_) begin_ -= trace_frame_count_;
  if (++in_window_ == window_) in_window_ = 0;
  return frame < trace_frame_count_ ? frame : frame - trace_frame_count_;
}

uint32_t OffsetOfSeed(const ReplayScene& scene, uint64_t seed) {
  return static_cast<uint32_t>(((seed * math::kGoldenGamma) >> 32) * scene.trace_frame_count() >>
                               32);
}

FixedCosts::FixedCosts(const ReplayScene& scene, uint64_t seed) : scene_(scene) {
  FrameOrder order(scene, OffsetOfSeed(scene, seed));
  order_.resize(scene.frame_count());
  for (uint32_t& trace_frame : order_) trace_frame = order.Next();
  const uint32_t arms = scene.arm_count();
  const uint32_t blocks = (scene.frame_count() + kBlock - 1) / kBlock;
  from_block_.resize(size_t{blocks} * arms);
  std::vector<double> totals(arms);
  for (uint32_t frame = scene.frame_count(); frame-- > 0;) {
    for (uint32_t arm = 0; arm < arms; ++arm) totals[arm] += FrameNs(frame, arm);
    if (frame % kBlock == 0) {
      std::copy(totals.begin(), totals.end(), from_block_.begin() + size_t{frame} / kBlock * arms);
    }
  }
}

double FixedCosts::FrameNs(uint32_t game_frame, uint32_t arm) const {
  return scene_.detection_ns(order_[game_frame], arm) +
         static_cast<double>(scene_.options().other_work_ns);
}

std::vector<double> FixedCosts::TotalsFrom(uint32_t first_frame) const {
  const uint32_t arms = scene_.arm_count();
  const uint32_t end = std::min((first_frame + kBlock - 1) / kBlock * kBlock, scene_.frame_count());
  std::vector<double> totals(arms);
  if (end < scene_.frame_count()) {
    const auto block = from_block_.begin() + size_t{end} / kBlock * arms;
    std::copy(block, block + arms, totals.begin());
  }
  for (uint32_t frame = first_frame; frame < end; ++frame) {
    for (uint32_t arm = 0; arm < arms; ++arm) totals[arm] += FrameNs(frame, arm);
  }
  return totals;
}

// Returns the extra time of the frames after a switch to `arm`, compared with a running structure.
double FixedCosts::SwitchNs(uint32_t game_frame, uint32_t arm, bool warm) const {
  const auto slowdown = scene_.slowdown(order_[game_frame], arm);
  double extra_ns = 0;
  if (warm) {
    extra_ns = scene_.detection_ns(order_[game_frame], arm) * (slowdown.back() - 1);
  } else {
    const size_t count = std::min<size_t>(slowdown.size(), scene_.frame_count() - game_frame);
    for (size_t k = 0; k < count; ++k) {
      extra_ns += scene_.detection_ns(order_[game_frame + k], arm) * (slowdown[k] - 1);
    }
  }
  return std::max(extra_ns, 0.0);
}

FixedCosts::OracleCost FixedCosts::Oracle(int64_t interval_ns, bool warm) const {
  struct Path {
    double cost_ns = 0;
    uint32_t switch_count = 0;
    std::array<uint32_t, decision::kMaxArms> frame_counts{};
  };
  const auto cheaper = [](const Path& a, const Path& b) { return a.cost_ns < b.cost_ns; };
  const uint32_t arms = scene_.arm_count();
  const auto interval = static_cast<uint32_t>(std::clamp<uint64_t>(
      static_cast<uint64_t>(interval_ns) / scene_.options().frame_ns, 1, scene_.frame_count()));
  OracleCost oracle;
  // Dynamic programming: at every interval, each path either continues or is replaced by a switch
  // from the cheapest path.
  std::vector<Path> paths(arms);  // the cheapest path that ends on each arm
  for (uint32_t frame = 0; frame < scene_.frame_count(); ++frame) {
    if (frame > 0 && frame % interval == 0) {
      const Path best = *std::min_element(paths.begin(), paths.end(), cheaper);
      for (uint32_t arm = 0; arm < arms; ++arm) {
        const Path other = {best.cost_ns + SwitchNs(frame, arm, warm), best.switch_count + 1,
                            best.frame_counts};
        paths[arm] = std::min(paths[arm], other, cheaper);
      }
    }
    double min_ns = std::numeric_limits<double>::infinity();
    for (uint32_t arm = 0; arm < arms; ++arm) {
      const double ns = FrameNs(frame, arm);
      paths[arm].cost_ns += ns;
      ++paths[arm].frame_counts[arm];
      min_ns = std::min(min_ns, ns);
    }
    oracle.frame_ns += min_ns;
  }
  // The path of the oracle is the cheapest one at the end.
  const Path best = *std::min_element(paths.begin(), paths.end(), cheaper);
  oracle.regime_ns = best.cost_ns;
  oracle.switch_count = best.switch_count;
  const auto dominant = std::max_element(best.frame_counts.begin(), best.frame_counts.end());
  oracle.dominant_arm = static_cast<uint32_t>(dominant - best.frame_counts.begin());
  oracle.active_share = static_cast<double>(*dominant) / scene_.frame_count();
  return oracle;
}

}  // namespace sweepstake::cli
