#include "engine_client/decider/session/session_tally.h"

#include <algorithm>
#include <optional>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {

// Returns the windows in this regime. Drops those of an earlier regime at the same place.
RegimeUse& SessionTally::UseOf(RegimeId id) {
  auto use = std::find_if(uses_.begin(), uses_.end(),
                          [&](const RegimeUse& each) { return each.id.place == id.place; });
  if (use == uses_.end()) use = uses_.emplace(use);
  if (use->arm_us.empty() || use->id != id) {
    *use = {.id = id,
            .arm_us = std::vector<double>(total_.arm_us.size()),
            .known_frame_counts = std::vector<uint64_t>(total_.arm_us.size())};
  }
  return *use;
}

void SessionTally::AddFrame(const FrameSample& frame, const Policy& policy) {
  if (frame.arm != arm_) {
    File(policy);
    arm_ = frame.arm;
    frames_ = {};
  }
  frames_.Add(frame);
}

void SessionTally::File(const Policy& policy) {
  if (!frames_.shows_cost()) return frames_.Clear();
  RegimeUse& use = UseOf(policy.present_regime());
  const double ran_us =
      1e3 * frames_.Metrics().calm_detection_ms * static_cast<double>(frames_.frame_count());
  const std::optional<double> own = policy.ExpectedLogCost(arm_);
  for (RegimeUse* each : {&use, &total_}) {
    each->frame_count += frames_.frame_count();
    each->ran_us += ran_us;
  }
  for (uint32_t other = 0; other < total_.arm_us.size(); ++other) {
    const std::optional<double> cost = policy.ExpectedLogCost(other);
    const bool is_known = own && cost;
    for (RegimeUse* each : {&use, &total_}) {
      each->arm_us[other] += is_known ? ran_us * math::Exp(*cost - *own) : ran_us;
      if (is_known) each->known_frame_counts[other] += frames_.frame_count();
    }
  }
  frames_.Clear();
}

void SessionTally::AddSwitchCost(const SwitchCost& cost, const Policy& policy) {
  const double cost_us = static_cast<double>(TotalNs(cost)) * 1e-3;
  UseOf(policy.present_regime()).ran_us += cost_us;
  total_.ran_us += cost_us;
}

void SessionTally::AddSwitch(int64_t executed_ns) {
  switches_ns_.push_back(executed_ns);
  if (switches_ns_.size() > kMaxSwitches) switches_ns_.pop_front();
}

uint32_t SessionTally::RecentSwitchCount(int64_t now_ns) const {
  const auto recent =
      std::count_if(switches_ns_.begin(), switches_ns_.end(),
                    [&](int64_t switched) { return switched > now_ns - kLatelyNs; });
  return static_cast<uint32_t>(recent);
}

}  // namespace sweepstake::decision
