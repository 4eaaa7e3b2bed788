#include "engine_client/decider/policy/regime_memory.h"

#include <algorithm>

namespace sweepstake::decision {

// Returns the nearest regime that the features belong to, if any.
std::optional<uint32_t> RegimeMemory::Find(const RegimeFeatures& features) const {
  std::optional<uint32_t> found;
  double nearest = 1;
  for (uint32_t regime = 0; regime < regimes_.size(); ++regime) {
    const double distance = DistanceOf(regimes_[regime].centre, features);
    if (distance >= nearest) continue;
    nearest = distance;
    found = regime;
  }
  return found;
}

DescriptorMatch RegimeMemory::Match(const SceneDescriptor& descriptor) const {
  if (regimes_.empty()) return DescriptorMatch::kPresent;
  const std::optional<uint32_t> found = Find(FeaturesOf(descriptor));
  if (!found) return DescriptorMatch::kUnknown;
  return *found == current_ ? DescriptorMatch::kPresent : DescriptorMatch::kOther;
}

RegimeMemory::Recognition RegimeMemory::Observe(const SceneDescriptor& descriptor) {
  const RegimeFeatures features = FeaturesOf(descriptor);
  ++count_;
  const std::optional<uint32_t> found = Find(features);
  if (!found) return Begin(features);
  current_ = *found;
  Regime& regime = regimes_[current_];
  regime.last = count_;
  ++regime.count;
  const double weight = 1 / static_cast<double>(regime.count);
  for (size_t i = 0; i < features.size(); ++i)
    regime.centre[i] += weight * (features[i] - regime.centre[i]);
  return {.regime = current_};
}

RegimeId RegimeMemory::IdAt(uint32_t place) const {
  return {.place = place, .number = place < regimes_.size() ? regimes_[place].number : 0};
}

// Begins a regime. If there are kMaxRegimes, it replaces the one whose latest descriptor is the
// oldest.
RegimeMemory::Recognition RegimeMemory::Begin(const RegimeFeatures& features) {
  current_ = static_cast<uint32_t>(regimes_.size());
  if (current_ == kMaxRegimes) {
    const auto oldest =
        std::min_element(regimes_.begin(), regimes_.end(),
                         [](const Regime& a, const Regime& b) { return a.last < b.last; });
    current_ = static_cast<uint32_t>(oldest - regimes_.begin());
  } else {
    regimes_.emplace_back();
  }
  regimes_[current_] = {.centre = features, .number = begun_count_++, .count = 1, .last = count_};
  return {.regime = current_, .is_new = true};
}

}  // namespace sweepstake::decision
