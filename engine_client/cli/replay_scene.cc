#include "engine_client/cli/replay_scene.h"

#include <algorithm>
#include <cmath>

#include "engine_client/cli/statistics.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kMostGameFrames = 100'000'000;
std::optional<double> Measured(float value) {
  return value < 0 ? std::nullopt : std::optional<double>(value);
}

decision::SceneDescriptor Described(const SceneDescriptor& descriptor) {
  return {.object_count = Measured(descriptor.object_count),
          .density_ratio = Measured(descriptor.density_ratio),
          .size_spread = Measured(descriptor.size_spread),
          .speed_mean = Measured(descriptor.speed_mean),
          .speed_spread = Measured(descriptor.speed_spread),
          .clustering_ratio = Measured(descriptor.clustering_ratio),
          .static_ratio = Measured(descriptor.static_ratio)};
}

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
    return refused("the other work takes the whole frame; make --other-work less than --frame");
  }
  if (options.run_ns < options.frame_ns) {
    return refused("the run is shorter than a frame; make --run longer");
  }
  if (options.run_ns / options.frame_ns > kMostGameFrames) {
    return refused("the run has " + std::to_string(options.run_ns / options.frame_ns) +
                   " frames; make --run shorter or --frame longer, for at most " +
                   std::to_string(kMostGameFrames));
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

// The running structure's detection of `arm` in the frames of a burst: the median, since a
// disturbance of one frame would turn the burst's whole profile around.
double RunningNs(const CostTrace& trace, const TraceBurst& burst, uint32_t arm) {
  const uint32_t end = std::min(burst.first_frame + trace.burst_frame_count, trace.frame_count);
  std::vector<double> running_ns;
  for (uint32_t frame = burst.first_frame; frame < end; ++frame) {
    running_ns.push_back(static_cast<double>(trace.detection(frame, arm)));
  }
  return std::max(Median(std::move(running_ns)), 1.0);
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
  trace_frame_count_ = trace.frame_count;
  detection_ns_.assign(trace.detection_ns.begin(), trace.detection_ns.end());
  for (double& ns : detection_ns_) ns *= scale;
  aabb_check_count_ = trace.aabb_check_count;
  native_bytes_ = trace.native_bytes;
  object_count_ = trace.object_count;
  TakeBursts(trace, scale);
  TakeDescriptors(trace);
}

void ReplayScene::TakeBursts(const CostTrace& trace, double scale) {
  burst_frame_count_ = trace.burst_frame_count;
  for (const TraceBurst& traced : trace.bursts) {
    Burst& burst = bursts_.emplace_back();
    for (uint32_t arm = 0; arm < arm_count(); ++arm) {
      const double running_ns = RunningNs(trace, traced, arm);
      for (uint32_t k = 0; k < burst_frame_count_; ++k) {
        const auto ns = static_cast<double>(traced.detection_ns[arm * burst_frame_count_ + k]);
        burst.detection_ns.push_back(static_cast<uint64_t>(ns * scale));
        burst.slowdown.push_back(ns / running_ns);
      }
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
  for (const TracedDescriptor& traced : trace.descriptors) {
    descriptors_.push_back(Described(traced.descriptor));
  }
  if (descriptors_.empty()) return;
  uint32_t latest = 0;
  for (uint32_t frame = 0; frame < trace_frame_count_; ++frame) {
    while (latest + 1 < descriptors_.size() && trace.descriptors[latest + 1].frame <= frame) {
      ++latest;
    }
    latest_descriptor_.push_back(latest);
  }
}

const decision::SceneDescriptor* ReplayScene::descriptor(uint32_t trace_frame) const {
  return latest_descriptor_.empty() ? nullptr : &descriptors_[latest_descriptor_[trace_frame]];
}

ReplayScene::FreshArm ReplayScene::fresh_arm(uint32_t trace_frame, uint32_t arm) const {
  const Burst& burst = bursts_[nearest_burst_[trace_frame]];
  const size_t begin = size_t{arm} * burst_frame_count_;
  return {.detection_ns = std::span(burst.detection_ns).subspan(begin, burst_frame_count_),
          .slowdown = std::span(burst.slowdown).subspan(begin, burst_frame_count_)};
}

FrameOrder::FrameOrder(const ReplayScene& scene, uint32_t offset)
    : trace_frame_count_(scene.trace_frame_count()),
      trace_frames_per_game_frame_(static_cast<double>(scene.trace_frame_count()) /
                                   (static_cast<double>(scene.options().pass_ns) /
                                    static_cast<double>(scene.options().run_ns) *
                                    static_cast<double>(scene.frame_count()))),
      offset_(offset) {}

uint32_t FrameOrder::Next() {
  if (game_frame_ == clip_end_) BeginClip();
  ++game_frame_;
  const uint32_t frame = clip_begin_ + at_;
  if (++at_ == clip_length_) at_ = 0;
  return frame;
}

void FrameOrder::BeginClip() {
  const double frames = trace_frame_count_;
  const double position = offset_ + static_cast<double>(game_frame_) * trace_frames_per_game_frame_;
  const double pass = std::floor(position / frames);
  const double in_trace = std::clamp(position - pass * frames, 0.0, frames - 1);
  clip_begin_ =
      static_cast<uint32_t>(in_trace) / ReplayScene::kClipFrameCount * ReplayScene::kClipFrameCount;
  clip_length_ = std::min(ReplayScene::kClipFrameCount, trace_frame_count_ - clip_begin_);
  at_ = 0;
  const double end_position = pass * frames + clip_begin_ + clip_length_;
  const double end = std::ceil((end_position - offset_) / trace_frames_per_game_frame_);
  clip_end_ = std::max(game_frame_ + 1, static_cast<uint64_t>(end));
}

uint32_t OffsetOfSeed(const ReplayScene& scene, uint64_t seed) {
  constexpr uint64_t kGoldenRatio = 0x9E3779B97F4A7C15;  // of 2^64
  return static_cast<uint32_t>(((seed * kGoldenRatio) >> 32) * scene.trace_frame_count() >> 32);
}

}  // namespace sweepstake::cli
