// The page /metrics in the text format 0.0.4 of Prometheus, and functions that make a metric family
// with one value.
#pragma once

#include <prometheus/metric_family.h>

#include <string>
#include <vector>

#include "server/web/http_message.h"

namespace sweepstake::web {

prometheus::MetricFamily CounterOf(std::string name, std::string help, double value);
prometheus::MetricFamily GaugeOf(std::string name, std::string help, double value);

Page MetricsPage(const std::vector<prometheus::MetricFamily>& families);

}  // namespace sweepstake::web
