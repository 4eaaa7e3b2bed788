#include "engine_client/adaptive/lane_cost.h"

#include <algorithm>

#include "engine_client/adaptive/one_writer_sum.h"

namespace sweepstake {

void LaneCost::End(uint32_t begun, uint64_t detection_ns, uint32_t epoch) noexcept {
  const bool is_beside = begun % 2 != 0 || work_.load(std::memory_order_relaxed) != begun;
  Cell& cell = is_beside ? beside_ : alone_;
  AddAsOnlyWriter(cell.count, 1);
  AddAsOnlyWriter(cell.ns, detection_ns);
  epoch_.store(epoch, std::memory_order_relaxed);
}

void LaneCost::BeginWork() {
  alone_between_ = alone_.sum() - alone_before_;
  beside_before_ = beside_.sum();
  work_.store(work_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

// Compares the searches during the stretch with the searches before it. A search that overlaps the
// start or the end of the stretch counts as during it, so all of its extra time is included. The
// time that the searches would take without the lane is limited to the stretch's wall time. If
// fewer searches ran before the stretch than during it, nothing is compared: the few searches
// before the first sweep run on structures that still grow.
double LaneCost::EndWork(uint64_t wall_ns) {
  work_.store(work_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  const Searches beside = beside_.sum() - beside_before_;
  const uint32_t epoch = epoch_.load(std::memory_order_relaxed);
  const auto wall = static_cast<double>(wall_ns);
  if (beside.count > 0 && alone_between_.count >= beside.count && epoch == epoch_before_) {
    const double alone_ns =
        static_cast<double>(alone_between_.ns) / static_cast<double>(alone_between_.count);
    const double without_ns = alone_ns * static_cast<double>(beside.count);
    const double base_ns = std::min(without_ns, wall);
    const double extra_ns = static_cast<double>(beside.ns) - without_ns;
    extra_ns_ = kKept * extra_ns_ + std::clamp(extra_ns, -kMost * base_ns, kMost * base_ns);
    base_ns_ = kKept * base_ns_ + base_ns;
  }
  epoch_before_ = epoch;
  alone_before_ = alone_.sum();
  const double cost_ns = wall * slowdown();
  AddAsOnlyWriter(total_ns_, static_cast<uint64_t>(cost_ns));
  return cost_ns;
}

double LaneCost::slowdown() const {
  return std::max((kPriorSlowdown * kPriorNs + extra_ns_) / (kPriorNs + base_ns_), 0.0);
}

}  // namespace sweepstake
