#include "server/web/metrics_page.h"

#include <prometheus/text_serializer.h>

#include <utility>

namespace sweepstake::web {
namespace {

prometheus::MetricFamily FamilyOf(std::string name, std::string help, prometheus::MetricType type) {
  prometheus::MetricFamily family;
  family.name = std::move(name);
  family.help = std::move(help);
  family.type = type;
  family.metric.emplace_back();
  return family;
}

}  // namespace

prometheus::MetricFamily CounterOf(std::string name, std::string help, double value) {
  auto family = FamilyOf(std::move(name), std::move(help), prometheus::MetricType::Counter);
  family.metric.front().counter.value = value;
  return family;
}

prometheus::MetricFamily GaugeOf(std::string name, std::string help, double value) {
  auto family = FamilyOf(std::move(name), std::move(help), prometheus::MetricType::Gauge);
  family.metric.front().gauge.value = value;
  return family;
}

Page MetricsPage(const std::vector<prometheus::MetricFamily>& families) {
  return {.body = prometheus::TextSerializer().Serialize(families),
          .content_type = "text/plain; version=0.0.4; charset=utf-8"};
}

}  // namespace sweepstake::web
