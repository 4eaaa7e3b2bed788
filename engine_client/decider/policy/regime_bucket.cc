#include "engine_client/decider/policy/regime_bucket.h"

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
constexpr std::string_view kUnmeasuredText = "-";
constexpr char kSeparator = '/';

std::string TextOf(double feature) {
  if (feature == kUnmeasured) return std::string(kUnmeasuredText);
  // The limits do not matter to a real scene. They keep the text of a false descriptor short.
  return std::to_string(static_cast<int>(std::floor(std::clamp(feature, -100.0, 100.0))));
}

std::optional<double> FeatureOf(std::string_view text) {
  if (text == kUnmeasuredText) return kUnmeasured;
  const bool is_negative = text.starts_with('-');
  int cell = 0;
  for (const char digit : text.substr(is_negative ? 1 : 0)) {
    if (digit < '0' || digit > '9' || cell > 100) return std::nullopt;
    cell = 10 * cell + (digit - '0');
  }
  const double middle = (is_negative ? -cell : cell) + 0.5;
  // Rejects other spellings of the number, because a cell has only one name.
  if (text != TextOf(middle)) return std::nullopt;
  return middle;
}

}  // namespace

RegimeFeatures FeaturesOf(const SceneDescriptor& descriptor) {
  RegimeFeatures features{kUnmeasured, kUnmeasured, kUnmeasured};
  if (IsMeasured(descriptor.object_count))
    features[0] = math::Log(std::max<double>(descriptor.object_count, 1)) / kCountStep;
  if (IsMeasured(descriptor.speed_mean))
    features[1] = math::Log(std::max<double>(descriptor.speed_mean, kMinSpeed)) / kSpeedStep;
  if (IsMeasured(descriptor.static_ratio))
    features[2] = std::clamp<double>(descriptor.static_ratio, 0, 1) / kStaticStep;
  return features;
}

RegimeCentre CentreOf(const RegimeFeatures& features) {
  RegimeCentre centre;
  if (features[0] != kUnmeasured) centre.object_count = math::Exp(features[0] * kCountStep);
  if (features[1] != kUnmeasured) centre.speed_mean = math::Exp(features[1] * kSpeedStep);
  if (features[2] != kUnmeasured) centre.static_ratio = features[2] * kStaticStep;
  return centre;
}

double DistanceOf(const RegimeFeatures& a, const RegimeFeatures& b) {
  double distance = 0;
  for (size_t i = 0; i < a.size(); ++i) distance = std::max(distance, std::abs(a[i] - b[i]));
  return distance;
}

std::string BucketOf(const RegimeFeatures& features) {
  std::string bucket;
  bool is_measured = false;
  for (const double feature : features) {
    if (!bucket.empty()) bucket += kSeparator;
    bucket += TextOf(feature);
    is_measured = is_measured || feature != kUnmeasured;
  }
  return is_measured ? bucket : std::string();
}

std::optional<RegimeFeatures> MiddleOf(std::string_view bucket) {
  RegimeFeatures middle{kUnmeasured, kUnmeasured, kUnmeasured};
  if (bucket.empty()) return middle;
  for (size_t i = 0; i < middle.size(); ++i) {
    const bool is_last = i + 1 == middle.size();
    const size_t end = is_last ? bucket.size() : bucket.find(kSeparator);
    if (end == std::string_view::npos) return std::nullopt;
    const std::optional<double> feature = FeatureOf(bucket.substr(0, end));
    if (!feature) return std::nullopt;
    middle[i] = *feature;
    bucket.remove_prefix(is_last ? end : end + 1);
  }
  if (BucketOf(middle).empty()) return std::nullopt;  // the empty text is this bucket's only name
  return middle;
}

std::optional<BucketRange> RangeOf(std::string_view bucket) {
  const std::optional<RegimeFeatures> middle = MiddleOf(bucket);
  if (!middle) return std::nullopt;
  RegimeFeatures low = *middle, high = *middle;
  for (size_t i = 0; i < middle->size(); ++i) {
    if (low[i] == kUnmeasured) continue;
    low[i] -= 0.5;
    high[i] += 0.5;
  }
  return BucketRange{CentreOf(low), CentreOf(high)};
}

std::optional<size_t> NearestOf(std::span<const std::string> buckets,
                                const RegimeFeatures& features, double limit) {
  std::optional<size_t> found;
  for (size_t i = 0; i < buckets.size(); ++i) {
    const double distance = DistanceOf(*MiddleOf(buckets[i]), features);
    if (distance >= limit) continue;
    limit = distance;
    found = i;
  }
  return found;
}

}  // namespace sweepstake::decision
