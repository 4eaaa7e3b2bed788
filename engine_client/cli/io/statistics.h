// The statistics that experiments are reported with: means with spread, bootstrap intervals, paired
// tests. Pure functions, safe from any thread; the same numbers and seed give the same answer.
//
// Samples are few (5 to some hundred): nothing here is made for more than some thousand values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::cli {

// 0 of nothing.
double Mean(std::span<const double> values);
// Of a sample: n − 1 below the root. 0 of fewer than two values.
double SampleDeviation(std::span<const double> values);
// Half of the values lie below; between the middle two where there are two. 0 of nothing.
double Median(std::vector<double> values);

struct Interval {
  double low = 0;
  double high = 0;
};

struct BootstrapOptions {
  uint32_t resample_count = 10'000;
  uint64_t seed = 1;
  double level = 0.95;  // 0 to 1, both excluded
};

// Of the mean, by the percentile bootstrap (Efron and Tibshirani, An Introduction to the Bootstrap,
// ch. 13): the values are drawn anew with replacement. Narrow for fewer than some ten values.
// {mean, mean} of fewer than two.
Interval BootstrapMean(std::span<const double> values, const BootstrapOptions& options = {});

// Wilcoxon's signed-rank test of paired differences against 0, two-sided. Zero differences are left
// out, equal sizes share their mean rank. The probability is exact up to kExactWilcoxonMax pairs
// (all sign patterns are counted, ties included); above, normal with correction for ties and
// continuity.
struct WilcoxonResult {
  size_t pair_count = 0;      // without zero differences
  double positive_ranks = 0;  // W⁺: ranks of the positive differences, summed
  double probability = 1;     // of ranks at least as lopsided by chance; 1 where no pair is left
  double rank_correlation =
      0;  // (W⁺ − W⁻) ÷ (W⁺ + W⁻), the matched-pairs rank-biserial effect size
};
inline constexpr size_t kExactWilcoxonMax = 30;
WilcoxonResult WilcoxonSignedRank(std::span<const double> differences);

// Holm's step-down correction: the probabilities of a family of tests, in their order, as large as
// they must be for each to be compared with one level.
std::vector<double> HolmCorrected(std::span<const double> probabilities);

}  // namespace sweepstake::cli
