// The statistics of the reports: means with their spread, bootstrap intervals, paired tests. Pure
// functions, thread-safe. The same numbers and seed give the same result.
//
// Intended for samples of 5 to some thousand values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sweepstake::cli {

// Returns the arithmetic mean, or 0 if there are no values.
double Mean(std::span<const double> values);
// Returns the sample standard deviation (with n − 1), or 0 for fewer than two values.
double SampleDeviation(std::span<const double> values);
// Returns the median: the middle value, or the mean of the two middle values. Returns 0 if there
// are no values. The values may be in any order.
double Median(std::vector<double> values);

struct TimeSummary {
  double ms_median = 0;
  double ms_mean = 0;
  double ms_min = 0;
  double ms_p99 = 0;
};
// Returns median, mean, minimum and 99th percentile. REQUIRES: not empty.
TimeSummary Summarize(std::span<const double> times_ms);

// Returns the quantile at `ratio` by the nearest rank. REQUIRES: sorted, not empty.
double Quantile(const std::vector<double>& sorted, double ratio);

struct Interval {
  double low = 0;
  double high = 0;
};

struct BootstrapOptions {
  uint32_t resample_count = 10'000;
  uint64_t seed = 1;
  double level = 0.95;  // 0 to 1, both excluded
};

// Returns a confidence interval of the mean by the percentile bootstrap (Efron and Tibshirani, An
// Introduction to the Bootstrap, ch. 13), which resamples the values with replacement. With fewer
// than about ten values, the interval is too narrow. With fewer than two, it is {mean, mean}.
Interval BootstrapMean(std::span<const double> values, const BootstrapOptions& options = {});

// Wilcoxon's signed-rank test, two-sided: are the paired differences symmetric around 0?
// Differences of 0 are left out. Differences of equal size share their mean rank. Up to
// kMaxExactWilcoxon pairs the probability is exact: all sign patterns are counted, also with ties.
// For more pairs it comes from the normal distribution, corrected for ties and continuity.
struct WilcoxonResult {
  // Pairs whose difference is not zero.
  size_t pair_count = 0;
  // W⁺, the sum of the ranks of the positive differences.
  double positive_ranks = 0;
  // Probability that a result at least as extreme occurs by chance; 1 if all differences are 0.
  double probability = 1;
  // The smallest probability that this many pairs can have: all differences have the same sign. It
  // is 2^(1 − pair_count) where the probability is exact.
  double smallest_probability = 1;
  // (W⁺ − W⁻) ÷ (W⁺ + W⁻), the matched-pairs rank-biserial effect size.
  double rank_correlation = 0;
};
inline constexpr size_t kMaxExactWilcoxon = 30;
WilcoxonResult WilcoxonSignedRank(std::span<const double> differences);

// Returns the probabilities of several tests after Holm's step-down correction, in the given order.
// Each may then be compared with the same significance level.
std::vector<double> HolmCorrected(std::span<const double> probabilities);

}  // namespace sweepstake::cli
