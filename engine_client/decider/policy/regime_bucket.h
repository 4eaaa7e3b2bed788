// The features by which regimes of a scene are compared, and the buckets in which stores file the
// evidence of each regime.
//
// The space of the features is divided into cells, whose sides are one step of each feature. A
// bucket is the name of a cell: the numbers of the cell, such as "13/-4/0". A feature that was not
// measured is "-". The empty text is the bucket of evidence without a scene descriptor.
//
// A cell's middle is at most half a step from each of its points, except in the outermost cells,
// which contain all features beyond them. Stored evidence therefore needs no descriptor besides its
// bucket. Pure functions; the same results on every platform.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/regime_report.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// ln(object count), ln(mean speed) and static ratio, each in steps.
using RegimeFeatures = std::array<double, 3>;

RegimeFeatures FeaturesOf(const SceneDescriptor& descriptor);
// Inverts FeaturesOf.
RegimeCentre CentreOf(const RegimeFeatures& features);

// Returns the largest difference of a feature, in steps. Two descriptors may belong to one regime
// if it is below 1. A feature that was not measured is near only to one that was not measured.
double DistanceOf(const RegimeFeatures& a, const RegimeFeatures& b);

std::string BucketOf(const RegimeFeatures& features);
// Returns the middle of the bucket's cell. This and RangeOf return nothing if the text is not a
// bucket.
std::optional<RegimeFeatures> MiddleOf(std::string_view bucket);

// The descriptors of a bucket, as two corners of its cell. A feature that was not measured is
// absent in both.
struct BucketRange {
  RegimeCentre low;
  RegimeCentre high;
};
std::optional<BucketRange> RangeOf(std::string_view bucket);

// Returns the index of the bucket whose middle is the nearest one to these features. Returns
// nothing if none is nearer than `limit`. REQUIRES: all of them are buckets.
std::optional<size_t> NearestOf(std::span<const std::string> buckets,
                                const RegimeFeatures& features, double limit);

// Priors of regimes of a scene, by bucket.
struct RegimePriors {
  std::vector<std::string> buckets;  // distinct, and not empty
  // The priors of all arms for the first bucket, then for the second one, and so on.
  std::vector<BetaPosterior> posteriors;
  // The first buckets have stored evidence of the scene. The others have only that of other scenes.
  uint32_t stored_count = 0;

  std::span<const BetaPosterior> Of(size_t bucket) const {
    const size_t arm_count = posteriors.size() / buckets.size();
    return std::span(posteriors).subspan(bucket * arm_count, arm_count);
  }
};

}  // namespace sweepstake::decision
