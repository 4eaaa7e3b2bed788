#include "engine_client/decider/policy/regime_memory.h"

#include <algorithm>
#include <cmath>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

// A descriptor does not belong to a regime if one of its features differs from the regime's by more
// than the step below.
constexpr double kCountStep = 0.7;  // difference of ln(object count)
constexpr double kSpeedStep = 1;    // difference of ln(mean speed)
constexpr double kStaticStep = 0.3;
constexpr double kMinSpeed = 1e-6;     // world units per frame
constexpr double kUnmeasured = -1000;  // stands for a feature that was not measured

}  // namespace

RegimeMemory::Features RegimeMemory::FeaturesOf(const SceneDescriptor& descriptor) {
  Features features{kUnmeasured, kUnmeasured, kUnmeasured};
  if (IsMeasured(descriptor.object_count))
    features[0] = math::Log(std::max<double>(descriptor.object_count, 1)) / kCountStep;
  if (IsMeasured(descriptor.speed_mean))
    features[1] = math::Log(std::max<double>(descriptor.speed_mean, kMinSpeed)) / kSpeedStep;
  if (IsMeasured(descriptor.static_ratio)) features[2] = descriptor.static_ratio / kStaticStep;
  return features;
}

double RegimeMemory::Distance(const Features& a, const Features& b) {
  double distance = 0;
  for (size_t i = 0; i < a.size(); ++i) distance = std::max(distance, std::abs(a[i] - b[i]));
  return distance;
}

// Returns the nearest regime that the features belong to, if any.
std::optional<uint32_t> RegimeMemory::Find(const Features& features) const {
  std::optional<uint32_t> found;
  double nearest = 1;
  for (uint32_t regime = 0; regime < regimes_.size(); ++regime) {
    const double distance = Distance(regimes_[regime].centre, features);
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
  const Features features = FeaturesOf(descriptor);
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

// Inverts FeaturesOf.
RegimeCentre RegimeMemory::CentreAt(uint32_t place) const {
  RegimeCentre centre;
  if (place >= regimes_.size()) return centre;
  const Features& features = regimes_[place].centre;
  if (features[0] != kUnmeasured) centre.object_count = math::Exp(features[0] * kCountStep);
  if (features[1] != kUnmeasured) centre.speed_mean = math::Exp(features[1] * kSpeedStep);
  if (features[2] != kUnmeasured) centre.static_ratio = features[2] * kStaticStep;
  return centre;
}

// Begins a regime. If there are kMaxRegimes, it replaces the one whose latest descriptor is the
// oldest.
RegimeMemory::Recognition RegimeMemory::Begin(const Features& features) {
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
