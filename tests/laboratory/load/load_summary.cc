#include "tests/laboratory/load/load_summary.h"

#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {

using Json = nlohmann::ordered_json;

Json LoadJson(const LoadPlan& plan, const LoadResult& result) {
  const double batches_per_s = static_cast<double>(result.measured_batch_count) / result.measured_s;
  Json json = {
      {"streams", plan.stream_count},
      {"batches_per_s", batches_per_s},
      {"frames_per_s", batches_per_s * plan.batch_frames},
      {"acknowledged_per_s", static_cast<double>(result.acknowledged_count) / result.measured_s},
      {"batches", result.batch_count},
      {"bail_outs", result.bail_out_count},
      {"unsent_batches", result.unsent_count},
      {"rejected", result.rejected_count},
      {"finished", result.finished_count},
      {"measured_s", result.measured_s}};
  const auto add_quantile = [&](const char* name, const std::vector<double>& sorted, double ratio) {
    if (!sorted.empty()) json[name] = Quantile(sorted, ratio);
  };
  add_quantile("hello_latency_ms_p50", result.hello_latency_ms, 0.5);
  add_quantile("hello_latency_ms_p99", result.hello_latency_ms, 0.99);
  add_quantile("decision_latency_ms_p50", result.decision_latency_ms, 0.5);
  add_quantile("decision_latency_ms_p99", result.decision_latency_ms, 0.99);
  add_quantile("commit_lag_ms_p50", result.commit_lag_ms, 0.5);
  add_quantile("commit_lag_ms_p99", result.commit_lag_ms, 0.99);
  add_quantile("tick_lateness_ms_p99", result.tick_lateness_ms, 0.99);
  if (result.reconnect_s) json["reconnect_s"] = *result.reconnect_s;
  if (result.server_cpu_s) json["server_cpu_s"] = *result.server_cpu_s;
  if (result.generator_cpu_s) json["generator_cpu_s"] = *result.generator_cpu_s;
  return json;
}

std::string LoadText(const LoadPlan& plan, const LoadResult& result) {
  TextTable table({"figure", "value"});
  const Json figures = LoadJson(plan, result);
  for (const auto& [name, value] : figures.items()) {
    table.AddRow({name, value.is_number_float() ? Fixed(value.get<double>(), 2) : value.dump()});
  }
  return table.Text();
}

}  // namespace sweepstake::cli
