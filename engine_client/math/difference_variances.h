// Independent variances whose pairwise sums approximate the variances of the differences between
// correlated variables. Which variable is the lowest depends on the covariance only through these
// differences.
//
// Pure, deterministic, thread-safe.
#pragma once

#include <span>
#include <vector>

namespace sweepstake::decision {

// Returns v with vᵢ + vⱼ ≈ Var(yᵢ − yⱼ) and vᵢ >= 0, by weighted least squares of the relative
// deviation. A pair has a high weight if both of its variables may be the lowest, judged by
// comparing each with the variable of lowest mean. The result is exact if the covariance is a
// diagonal matrix plus a constant. If only two variables can be the lowest, it is exact for these
// two. REQUIRES: covariance is symmetric, row by row, means.size()² numbers, all finite.
std::vector<double> IndependentVariancesLike(std::span<const double> means,
                                             std::span<const double> covariance);

}  // namespace sweepstake::decision
