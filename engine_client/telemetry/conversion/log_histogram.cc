#include "engine_client/telemetry/conversion/log_histogram.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sweepstake {

std::optional<double> QuantileOf(const v1::LogHistogram& histogram, double share) {
  if (histogram.counts_size() != histogram.bucket_steps_size()) return std::nullopt;
  uint64_t total = 0;
  for (const uint32_t count : histogram.counts()) total += count;
  if (total == 0) return std::nullopt;
  const double rank = std::max(1.0, std::ceil(share * static_cast<double>(total)));
  uint64_t bucket = 0;
  uint64_t below = 0;
  for (int i = 0; i < histogram.counts_size() && static_cast<double>(below) < rank; ++i) {
    bucket += histogram.bucket_steps(i);
    below += histogram.counts(i);
  }
  return bucket == 0 ? 0 : std::exp2((static_cast<double>(bucket) - 0.5) / 8);
}

}  // namespace sweepstake
