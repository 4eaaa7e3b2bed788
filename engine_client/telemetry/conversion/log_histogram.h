// Quantiles of the histograms that the daemon sends. Pure functions.
#pragma once

#include <optional>

#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake {

// Returns the quantile: the value that `share` (0 to 1) of the values do not exceed. Its error is
// at most 4.5 %. Absent if the histogram is empty or malformed.
std::optional<double> QuantileOf(const v1::LogHistogram& histogram, double share);

}  // namespace sweepstake
