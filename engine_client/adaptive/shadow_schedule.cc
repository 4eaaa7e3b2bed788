#include "engine_client/adaptive/shadow_schedule.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sweepstake {
namespace {

// The search time that permits kWorkAheadNs of the lane's work.
constexpr auto kSearchAheadNs = static_cast<uint64_t>(
    static_cast<double>(ShadowSchedule::kWorkAheadNs) / ShadowSchedule::kMaxWorkRatio);

bool HasMoved(uint64_t now, uint64_t reference) {
  const double before = static_cast<double>(reference);
  const double change = static_cast<double>(now) - before;
  return std::max(change, -change) > ShadowSchedule::kChangeRatio * before;
}

// Returns the median. For an even number of values, this is the lower one of the two middle values.
uint64_t LowerMedian(std::span<const uint64_t> values) {
  std::array<uint64_t, kShadowBurstFrames> sorted;
  std::copy(values.begin(), values.end(), sorted.begin());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle,
                   sorted.begin() + static_cast<std::ptrdiff_t>(values.size()));
  return *middle;
}

}  // namespace

ShadowVisit SummarizeVisit(std::span<const uint64_t> frame_ns, uint64_t cap_ns) {
  assert(!frame_ns.empty() && frame_ns.size() <= kShadowBurstFrames);
  constexpr size_t kUnmeasured = 1 + kShadowWarmUpFrames;
  ShadowVisit visit{.build_ns = frame_ns[0], .busy_ns = frame_ns[0]};
  size_t count = 1;
  while (count < frame_ns.size() && visit.busy_ns < cap_ns) visit.busy_ns += frame_ns[count++];
  visit.capped = count < frame_ns.size();
  const std::span<const uint64_t> ran = frame_ns.first(count);
  if (count <= kUnmeasured) {
    visit.detection_ns = *std::min_element(ran.begin(), ran.end());
    return visit;
  }
  visit.frame_count = static_cast<uint32_t>(count - kUnmeasured);
  visit.detection_ns = LowerMedian(ran.subspan(kUnmeasured));
  return visit;
}

ShadowSchedule::ShadowSchedule(const ShadowScheduleOptions& options, uint32_t arm_count)
    : options_(options), arms_(arm_count) {
  assert(arm_count >= 1 && options.duty_ratio > 0 && options.duty_ratio <= 1);
}

uint64_t ShadowSchedule::next_sweep_ns() const {
  if (sweep_ == 0) return 0;
  const double spacing_ns = static_cast<double>(busy_ns_) / options_.duty_ratio;
  const uint64_t spaced_ns =
      begun_ns_ + std::max(options_.sweep_interval_min_ns, static_cast<uint64_t>(spacing_ns));
  return std::max(spaced_ns, paid_ns_);
}

bool ShadowSchedule::IsDue(uint64_t now_ns, uint64_t search_ns) const {
  const bool may_work =
      matched_ns_ <= search_ns + kSearchAheadNs || now_ns >= begun_ns_ + kMaxSpacingNs;
  return may_work && now_ns >= next_sweep_ns();
}

void ShadowSchedule::Charge(uint64_t now_ns, double cost_ns) {
  const uint64_t saved_ns = now_ns - std::min(now_ns, kSavingsNs);
  paid_ns_ = std::max(paid_ns_, saved_ns) + static_cast<uint64_t>(cost_ns / kMaxCostRatio);
}

void ShadowSchedule::GrantSavings() {
  if (begun_ns_ - granted_ns_ < kSavingsNs) return;
  granted_ns_ = begun_ns_;
  paid_ns_ = std::min(paid_ns_, begun_ns_ - kSavingsNs);
}

void ShadowSchedule::Begin(uint64_t now_ns, uint64_t search_ns, uint32_t active_arm,
                           uint32_t object_count) {
  assert(active_arm < arms_.size());
  matched_ns_ = std::clamp(matched_ns_, search_ns - std::min(search_ns, kSearchAheadNs),
                           search_ns + kSearchAheadNs);
  begun_ns_ = now_ns;
  if (++sweep_ == 1 || HasMoved(object_count, reference_count_)) {
    Renew(/*end_back_off=*/true);
    reference_count_ = object_count;
  }
  busy_ns_ = 0;
  active_arm_ = active_arm;
}

std::optional<uint32_t> ShadowSchedule::NextArm() const {
  const uint64_t best_ns = BestCost();
  for (uint32_t place = 0; place < arms_.size(); ++place) {
    if (Due(ArmAt(place), best_ns)) return ArmAt(place);
  }
  return std::nullopt;
}

void ShadowSchedule::OnVisit(const ShadowVisit& visit) {
  Arm& arm = arms_[visit.arm];
  const bool is_known = visit.is_measured || visit.capped;
  const uint64_t cost_ns = std::max<uint64_t>(visit.detection_ns, 1);
  if (is_known && visit.arm == active_arm_ && arm.reference_ns > 0 &&
      HasMoved(cost_ns, arm.reference_ns)) {
    Renew(/*end_back_off=*/false);
  }
  arm.last_sweep = sweep_;
  Spend(visit.busy_ns);
  if (!is_known) return;
  if (arm.reference_ns == 0) arm.reference_ns = cost_ns;
  arm.cost_ns = cost_ns;
  arm.too_big = visit.native_bytes > options_.memory_cap_bytes;
  const bool over = visit.capped || arm.too_big;
  arm.back_off = over ? std::clamp(2 * arm.back_off, 2U, kMaxPeriod) : 0;
}

void ShadowSchedule::Renew(bool end_back_off) {
  GrantSavings();
  for (Arm& arm : arms_) {
    if (end_back_off) arm.back_off = 0;
    arm.reference_ns = 0;
    if (arm.back_off == 0 && arm.last_sweep != sweep_) arm.last_sweep = 0;
  }
}

// Returns the arm at this position of a sweep that visits all arms.
uint32_t ShadowSchedule::ArmAt(uint32_t place) const {
  if (sweep_ % 2 == 0) place = static_cast<uint32_t>(arms_.size()) - 1 - place;
  if (place == 0) return active_arm_;
  return place <= active_arm_ ? place - 1 : place;
}

uint64_t ShadowSchedule::BestCost() const {
  uint64_t best_ns = 0;
  for (const Arm& arm : arms_) {
    if (arm.cost_ns > 0 && (best_ns == 0 || arm.cost_ns < best_ns)) best_ns = arm.cost_ns;
  }
  return best_ns;
}

// Returns the period of the arm's visits, in sweeps. REQUIRES: the arm has a cost.
uint64_t ShadowSchedule::Period(uint32_t index, uint64_t best_ns) const {
  const Arm& arm = arms_[index];
  const double ratio = static_cast<double>(arm.cost_ns) / static_cast<double>(best_ns);
  if ((index == active_arm_ || ratio <= kContenderRatio) && !arm.too_big) return 1;
  const double period = std::min(ratio * ratio, static_cast<double>(kMaxPeriod));
  return std::max<uint64_t>(static_cast<uint64_t>(period), arm.back_off);
}

bool ShadowSchedule::Due(uint32_t index, uint64_t best_ns) const {
  const uint64_t last_sweep = arms_[index].last_sweep;
  if (last_sweep == 0 || arms_[index].cost_ns == 0) return last_sweep != sweep_;
  return sweep_ - last_sweep >= Period(index, best_ns);
}

}  // namespace sweepstake
