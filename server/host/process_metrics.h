// The metrics that every Prometheus client exports about its process: start time, CPU, memory,
// descriptors.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

namespace sweepstake::server {

// Reads /proc.
std::vector<prometheus::MetricFamily> ProcessFamilies();

}  // namespace sweepstake::server
