// The metrics that every Prometheus client exports about its process: start time, CPU, memory,
// descriptors.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

namespace sweepstake::server {

// Reads /proc. A metric that cannot be read is omitted.
std::vector<prometheus::MetricFamily> ProcessFamilies();

}  // namespace sweepstake::server
