#include "tests/laboratory/replay/replay_fixed.h"

#include <algorithm>
#include <array>
#include <limits>

namespace sweepstake::cli {

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

// Returns how much longer the frames after a switch to `arm` take than with a running structure.
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
  // Dynamic programming: at every interval each path is continued or replaced by a switch from the
  // cheapest one.
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
  // The cheapest path at the end is the oracle's.
  const Path best = *std::min_element(paths.begin(), paths.end(), cheaper);
  oracle.regime_ns = best.cost_ns;
  oracle.switch_count = best.switch_count;
  const auto dominant = std::max_element(best.frame_counts.begin(), best.frame_counts.end());
  oracle.dominant_arm = static_cast<uint32_t>(dominant - best.frame_counts.begin());
  oracle.active_share = static_cast<double>(*dominant) / scene_.frame_count();
  return oracle;
}

}  // namespace sweepstake::cli
