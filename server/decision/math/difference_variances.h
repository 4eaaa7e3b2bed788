// Independent variances whose sums come near the variances of the differences between correlated
// variables. Who is the best depends on nothing else of a covariance.
//
// Pure, deterministic, thread-safe. Cost: 2 µs for 7 variables, 30 µs for 32.
#pragma once

#include <span>
#include <vector>

namespace sweepstake::decision {

// v with vᵢ + vⱼ ≈ Var(yᵢ − yⱼ), vᵢ >= 0, by weighted least squares of the relative deviation. The
// weight of a pair is how open it is whether either of the two is the lowest, judged against the
// lowest mean. Exact where the covariance is a diagonal plus what all variables share, and for the
// two that matter where there are two. REQUIRES: covariance is symmetric, row by row, means.size()²
// numbers, all finite.
std::vector<double> IndependentVariancesLike(std::span<const double> means,
                                             std::span<const double> covariance);

}  // namespace sweepstake::decision
