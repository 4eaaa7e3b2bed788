// What every Prometheus client tells of its process: start time, CPU, memory, descriptors.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

namespace sweepstake::web {

// Reads /proc.
std::vector<prometheus::MetricFamily> ProcessFamilies();

}  // namespace sweepstake::web
