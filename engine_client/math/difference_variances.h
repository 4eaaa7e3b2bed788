// Independent variances whose pairwise sums approximate the variances of the differences between
// correlated variables. Which variable is the best depends on nothing else of a covariance.
//
// Pure, deterministic, thread-safe.
#pragma once

#include <span>
#include <vector>

namespace sweepstake::decision {

// Returns v with vᵢ + vⱼ ≈ Var(yᵢ − yⱼ) and vᵢ >= 0, by weighted least squares of the relative
// deviation. A pair weighs the more the less certain it is, compared with the lowest mean, that
// neither of the two is the lowest. The result is exact for a covariance that is a diagonal plus
// what all variables share, and for the two that matter if only two do. REQUIRES: covariance is
// symmetric, row by row, means.size()² numbers, all finite.
std::vector<double> IndependentVariancesLike(std::span<const double> means,
                                             std::span<const double> covariance);

}  // namespace sweepstake::decision
