// The metrics of alerts, and those of single scenes. The setting metrics_scenes bounds the number
// of scenes. The series of a scene disappear when nobody plays it any more.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "server/alerts/alert_monitor.h"

namespace sweepstake::server {

// Families without a value are omitted.
std::vector<prometheus::MetricFamily> AlertFamilies(const alerts::AlertFigures& figures);

}  // namespace sweepstake::server
