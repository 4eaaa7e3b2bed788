#include "engine_client/cli/io/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine_client/math/hash.h"

namespace sweepstake::cli {
namespace {

// Returns a random index below `count`. For counts of some thousand, its bias is below 1e-15. The
// distributions of std:: are not used, because their results differ between platforms.
size_t DrawIndex(math::SplitMix64& random, size_t count) {
  const double unit = static_cast<double>(random.Next() >> 11) * 0x1p-53;
  return std::min(count - 1, static_cast<size_t>(unit * static_cast<double>(count)));
}

// Returns twice the rank of the absolute value of each difference. Equal values share their mean
// rank, which may be a half; doubled ranks are whole numbers.
std::vector<size_t> DoubledRanks(std::span<const double> differences) {
  std::vector<size_t> order(differences.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto size = [&](size_t i) { return std::abs(differences[i]); };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return size(a) < size(b); });
  std::vector<size_t> ranks(differences.size());
  for (size_t first = 0; first < order.size();) {
    size_t end = first + 1;
    while (end < order.size() && size(order[end]) == size(order[first])) ++end;
    // Ranks first + 1 … end are equal values, which share their mean rank.
    for (size_t i = first; i < end; ++i) ranks[order[i]] = first + 1 + end;
    first = end;
  }
  return ranks;
}

// Returns the fraction of all sign patterns whose doubled rank sum is at most `max_sum`.
double ShareAtMost(std::span<const size_t> ranks, size_t max_sum) {
  const size_t total = std::accumulate(ranks.begin(), ranks.end(), size_t{0});
  std::vector<double> patterns(total + 1, 0);  // patterns by sum; exact below 2^53
  patterns[0] = 1;
  for (const size_t rank : ranks) {
    for (size_t sum = total; sum >= rank; --sum) patterns[sum] += patterns[sum - rank];
  }
  const auto end = patterns.begin() + static_cast<std::ptrdiff_t>(max_sum) + 1;
  return std::ldexp(std::accumulate(patterns.begin(), end, 0.0), -static_cast<int>(ranks.size()));
}

// Returns the two-sided probability of a rank sum of at most `sum`, by the normal approximation.
double NormalProbability(std::span<const size_t> ranks, double sum) {
  // Variance of the rank sum if both signs are equally probable; the ranks are doubled.
  double variance = 0;
  for (const size_t rank : ranks) variance += static_cast<double>(rank * rank) / 16;
  const double mean =
      static_cast<double>(std::accumulate(ranks.begin(), ranks.end(), size_t{0})) / 4;
  const double z = std::max(0.0, mean - sum - 0.5) / std::sqrt(variance);
  return std::erfc(z / std::sqrt(2.0));
}

}  // namespace

double Mean(std::span<const double> values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double SampleDeviation(std::span<const double> values) {
  if (values.size() < 2) return 0;
  const double mean = Mean(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

TimeSummary Summarize(std::span<const double> times_ms) {
  std::vector<double> sorted(times_ms.begin(), times_ms.end());
  std::sort(sorted.begin(), sorted.end());
  const double sum = std::accumulate(sorted.begin(), sorted.end(), 0.0);
  return {Median(sorted), sum / static_cast<double>(sorted.size()), sorted.front(),
          Quantile(sorted, 0.99)};
}

double Quantile(const std::vector<double>& sorted, double ratio) {
  const auto rank = static_cast<size_t>(std::ceil(ratio * static_cast<double>(sorted.size())));
  return sorted[std::clamp<size_t>(rank, 1, sorted.size()) - 1];
}

Interval BootstrapMean(std::span<const double> values, const BootstrapOptions& options) {
  const double mean = Mean(values);
  if (values.size() < 2) return {mean, mean};
  math::SplitMix64 random{options.seed};
  std::vector<double> means(options.resample_count);
  for (double& resampled : means) {
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) sum += values[DrawIndex(random, values.size())];
    resampled = sum / static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  const double tail = (1 - options.level) / 2 * static_cast<double>(means.size() - 1);
  const auto low = static_cast<size_t>(std::floor(tail));
  return {means[low], means[means.size() - 1 - low]};
}

WilcoxonResult WilcoxonSignedRank(std::span<const double> differences) {
  std::vector<double> kept;
  std::copy_if(differences.begin(), differences.end(), std::back_inserter(kept),
               [](double difference) { return difference != 0; });
  WilcoxonResult result{.pair_count = kept.size()};
  if (kept.empty()) return result;
  const std::vector<size_t> ranks = DoubledRanks(kept);
  size_t positive = 0, total = 0;
  for (size_t i = 0; i < kept.size(); ++i) {
    total += ranks[i];
    if (kept[i] > 0) positive += ranks[i];
  }
  const auto probability_of = [&](size_t smaller) {
    const double doubled = kept.size() <= kMaxExactWilcoxon
                               ? 2 * ShareAtMost(ranks, smaller)
                               : NormalProbability(ranks, static_cast<double>(smaller) / 2);
    return std::min(1.0, doubled);
  };
  result.positive_ranks = static_cast<double>(positive) / 2;
  result.probability = probability_of(std::min(positive, total - positive));
  result.smallest_probability = probability_of(0);
  result.rank_correlation =
      (2 * static_cast<double>(positive) - static_cast<double>(total)) / static_cast<double>(total);
  return result;
}

std::vector<double> HolmCorrected(std::span<const double> probabilities) {
  std::vector<size_t> order(probabilities.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return probabilities[a] < probabilities[b]; });
  std::vector<double> corrected(probabilities.size());
  double largest = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const double factor = static_cast<double>(order.size() - i);
    largest = std::max(largest, std::min(1.0, factor * probabilities[order[i]]));
    corrected[order[i]] = largest;
  }
  return corrected;
}

}  // namespace sweepstake::cli
