#include "engine_client/decider/session/run_phases.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

#include "engine_client/math/random.h"

namespace sweepstake::decision {

std::vector<uint32_t> ExplorationOrder(uint64_t seed, uint32_t arm_count) {
  std::vector<uint32_t> order(arm_count);
  std::iota(order.begin(), order.end(), 0u);
  RandomStream stream(seed, RandomPurpose::kExplorationOrder, 0, 0);
  for (uint32_t left = arm_count; left > 1; --left)
    std::swap(order[left - 1], order[stream.NextBelow(left)]);
  return order;
}

Exploration::Exploration(uint64_t seed, uint32_t arm_count, uint32_t explored)
    : order_(ExplorationOrder(seed, arm_count)), explored_(explored) {
  assert(explored <= arm_count);
}

void Exploration::EndSlot() {
  assert(!done());
  ++explored_;
  command_count_ = 0;
}

bool Exploration::CountCommand() {
  assert(!done());
  return ++command_count_ <= kMaxCommands;
}

ObservationWindow::ObservationWindow(size_t arm_count, uint32_t active_arm)
    : active_arm_(active_arm) {
  summary_.active_ns.resize(arm_count);
}

void ObservationWindow::Start(int64_t now_ns) {
  assert(!summary_.start_ns);
  summary_.start_ns = now_ns;
  active_since_ns_ = now_ns;
  last_counted_ = false;
}

void ObservationWindow::Activate(uint32_t arm, SwitchReason reason, int64_t executed_ns) {
  last_counted_ = summary_.start_ns.has_value();
  if (last_counted_) {
    Charge(summary_, executed_ns);
    ++summary_.switch_count(reason);
    active_since_ns_ = std::max(active_since_ns_, executed_ns);
  }
  active_arm_ = arm;
  last_reason_ = reason;
}

void ObservationWindow::CorrectReason(SwitchReason reason) {
  if (!last_counted_) return;
  --summary_.switch_count(last_reason_);
  ++summary_.switch_count(reason);
  last_reason_ = reason;
}

ObservationSummary ObservationWindow::Summary(int64_t now_ns) const {
  ObservationSummary summary = summary_;
  if (summary.start_ns) Charge(summary, now_ns);
  return summary;
}

void ObservationWindow::Charge(ObservationSummary& summary, int64_t now_ns) const {
  if (now_ns <= active_since_ns_) return;
  summary.active_ns[active_arm_] +=
      static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(active_since_ns_);
}

}  // namespace sweepstake::decision
