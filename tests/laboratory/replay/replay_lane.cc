#include "tests/laboratory/replay/replay_lane.h"

#include <algorithm>
#include <utility>

#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"

namespace sweepstake::cli {
namespace {

// The number of frames that the preparation of the next arm takes, as in ShadowLane: the structure
// is built on one frame and updated on three more.
constexpr size_t kPreparationFrames = 1 + kShadowWarmUpFrames + 1;

constexpr double kMeanBusyNs = 10e9;  // mean length of a stretch of other work

constexpr double kSpikeShape = 1.5;
constexpr double kMaxSpike = 100;

// Scales the time cap of a visit, so that the cap ends the same visits as on the machine of the
// trace. This holds if no frame took 15 ms there: for such frames the real lane has a longer cap
// (ShadowOptions::visit_cap_ns).
ShadowScheduleOptions Scaled(ShadowScheduleOptions options, const ReplayScene& scene) {
  const double cap_ns = static_cast<double>(options.visit_cap_ns) * scene.time_ratio();
  options.visit_cap_ns = static_cast<uint64_t>(std::clamp(cap_ns, 1.0, 1e18));
  return options;
}

// Returns the random numbers of a visit. Visits are numbered from 1; number 0 is for the biases of
// a game.
decision::RandomStream StreamOf(uint64_t seed, uint64_t visit, uint32_t arm) {
  return {seed, decision::RandomPurpose::kReplayLane, visit, arm};
}

}  // namespace

ReplayLane::ReplayLane(const ReplayScene& scene, const ShadowScheduleOptions& options,
                       LaneErrors errors, uint64_t seed)
    : scene_(scene),
      errors_(std::move(errors)),
      seed_(seed),
      schedule_(Scaled(options, scene), scene.arm_count()) {}

// Returns the factor by which the lane's errors change the times of the visit.
double ReplayLane::ErrorOfVisit(uint32_t arm) const {
  decision::RandomStream of_arm = StreamOf(seed_, 0, arm);
  decision::RandomStream of_visit = StreamOf(seed_, visit_count_ + 1, arm);
  const double error =
      errors_.bias_deviation * DrawNormal(of_arm) + errors_.noise_deviation * DrawNormal(of_visit);
  double ratio = math::Exp(error) * (errors_.arm_ratios.empty() ? 1 : errors_.arm_ratios[arm]);
  if (of_visit.NextUniform() < errors_.spike_ratio) {
    ratio *= std::min(math::Pow(of_visit.NextUniform(), -1 / kSpikeShape), kMaxSpike);
  }
  return ratio;
}

std::optional<ShadowSample> ReplayLane::Advance(const Place& place) {
  const auto now_ns = static_cast<uint64_t>(place.now_ns);
  if (!visit_ && !schedule_.IsDue(now_ns, place.search_ns)) {
    next_event_ns_ = place.now_ns + static_cast<int64_t>(scene_.options().frame_ns);
    return std::nullopt;
  }
  if (!visit_) {
    sweep_ = place;
    schedule_.Begin(now_ns, place.search_ns, place.active_arm,
                    scene_.object_count(place.trace_frame));
    BeginVisit(place.now_ns);
    if (visit_) RepeatVisit();
    return std::nullopt;
  }
  const ShadowVisit visit = *visit_;
  schedule_.OnVisit(visit);
  ++visit_count_;
  busy_ns_ += visit.busy_ns;
  BeginVisit(next_event_ns_);
  uint32_t flags = 0;
  if (visit.arm == sweep_.active_arm) flags |= kShadowActive;
  if (visit.capped) flags |= kShadowCapped;
  return ShadowSample{.first_frame_index = sweep_.game_frame,
                      .detection_time_ns = visit.detection_ns,
                      .build_time_ns = visit.build_ns,
                      .aabb_check_count = scene_.aabb_check_count(sweep_.trace_frame, visit.arm),
                      .native_bytes = visit.native_bytes,
                      .arm = visit.arm,
                      .object_count = scene_.object_count(sweep_.trace_frame),
                      .frame_count = visit.frame_count,
                      .flags = flags};
}

void ReplayLane::BeginVisit(int64_t start_ns) {
  const std::optional<uint32_t> arm = schedule_.NextArm();
  if (!arm) {
    visit_.reset();
    Charge(sweep_.now_ns, start_ns);
    next_event_ns_ = static_cast<int64_t>(schedule_.next_sweep_ns());
    return;
  }
  visit_ = SummarizeVisit(FreshFrames(sweep_.trace_frame, *arm, ErrorOfVisit(*arm)),
                          schedule_.options().visit_cap_ns);
  visit_->arm = *arm;
  visit_->native_bytes = scene_.native_bytes(sweep_.trace_frame, *arm);
  next_event_ns_ = start_ns + static_cast<int64_t>(visit_->busy_ns);
}

// Repeats the first visit of a sweep, as the real lane does, for at most kShadowWarmUpNs of real
// time.
void ReplayLane::RepeatVisit() {
  const double max_ns = static_cast<double>(kShadowWarmUpNs) * scene_.time_ratio();
  const uint64_t repeated_ns = std::min(visit_->busy_ns, static_cast<uint64_t>(max_ns));
  schedule_.Spend(repeated_ns);
  busy_ns_ += repeated_ns;
  next_event_ns_ += static_cast<int64_t>(repeated_ns);
}

// Charges the cost of the lane's work to its budget. The real lane estimates this cost
// (lane_cost.h), here it is known.
void ReplayLane::Charge(int64_t begin_ns, int64_t end_ns) {
  schedule_.Charge(static_cast<uint64_t>(end_ns),
                   (errors_.contention_ratio - 1) * static_cast<double>(end_ns - begin_ns));
}

// Returns the times of a visit's frames for a structure of `arm` that is built on this frame,
// multiplied by `ratio`.
std::span<const uint64_t> ReplayLane::FreshFrames(uint32_t trace_frame, uint32_t arm,
                                                  double ratio) {
  fresh_ns_.clear();
  for (const double slowdown : scene_.slowdown(trace_frame, arm)) {
    if (fresh_ns_.size() == kShadowBurstFrames) break;
    const double ns = scene_.detection_ns(trace_frame, arm) * slowdown * ratio;
    fresh_ns_.push_back(static_cast<uint64_t>(std::max(ns, 1.0)));
    trace_frame = trace_frame + 1 < scene_.trace_frame_count() ? trace_frame + 1 : 0;
  }
  return fresh_ns_;
}

int64_t ReplayLane::WarmUp(uint32_t arm, const Place& place) {
  const auto frames = FreshFrames(place.trace_frame, arm);
  const auto frame_ns = static_cast<int64_t>(scene_.options().frame_ns);
  const size_t count = std::min<size_t>(frames.size(), kPreparationFrames);
  int64_t ready_ns = place.now_ns;
  int64_t work_ns = 0;
  for (const uint64_t ns : frames.first(count)) {
    work_ns += static_cast<int64_t>(ns);
    ready_ns += std::max(static_cast<int64_t>(ns), frame_ns);
  }
  schedule_.Spend(static_cast<uint64_t>(work_ns));
  Charge(ready_ns - work_ns, ready_ns);
  next_event_ns_ = std::max(next_event_ns_, place.now_ns) + (ready_ns - place.now_ns);
  return ready_ns;
}

double ReplayLoad::RatioAt(int64_t now_ns) {
  if (load_.ratio == 1) return 1;
  while (now_ns >= stretch_end_ns_) {
    ++stretch_count_;
    decision::RandomStream random(seed_, decision::RandomPurpose::kReplayLoad, stretch_count_, 0);
    const double mean_ns =
        stretch_count_ % 2 == 0 ? kMeanBusyNs : kMeanBusyNs * (1 - load_.share) / load_.share;
    stretch_end_ns_ += static_cast<int64_t>(-mean_ns * math::Log(random.NextUniform())) + 1;
  }
  return stretch_count_ % 2 == 0 ? load_.ratio : 1;
}

}  // namespace sweepstake::cli
