#include "server/decision/observation.h"

#include <algorithm>
#include <cassert>

namespace sweepstake::decision {

Observation::Observation(size_t arm_count, uint32_t active_arm) : active_arm_(active_arm) {
  summary_.active_ns.resize(arm_count);
}

void Observation::Start(int64_t now_ns) {
  assert(!summary_.start_ns);
  summary_.start_ns = now_ns;
  active_since_ns_ = now_ns;
  last_counted_ = false;
}

void Observation::Activate(uint32_t arm, SwitchReason reason, int64_t executed_ns) {
  last_counted_ = summary_.start_ns.has_value();
  if (last_counted_) {
    Charge(summary_, executed_ns);
    ++summary_.switch_count(reason);
    active_since_ns_ = std::max(active_since_ns_, executed_ns);
  }
  active_arm_ = arm;
  last_reason_ = reason;
}

void Observation::CorrectReason(SwitchReason reason) {
  if (!last_counted_) return;
  --summary_.switch_count(last_reason_);
  ++summary_.switch_count(reason);
  last_reason_ = reason;
}

ObservationSummary Observation::Summary(int64_t now_ns) const {
  ObservationSummary summary = summary_;
  if (summary.start_ns) Charge(summary, now_ns);
  return summary;
}

void Observation::Charge(ObservationSummary& summary, int64_t now_ns) const {
  if (now_ns <= active_since_ns_) return;
  summary.active_ns[active_arm_] +=
      static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(active_since_ns_);
}

}  // namespace sweepstake::decision
