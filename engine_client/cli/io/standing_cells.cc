#include "engine_client/cli/io/standing_cells.h"

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {

std::string RatioText(double ratio) {
  if (ratio >= 1e6) return ">999999";
  return Fixed(ratio, ratio < 10 ? 2 : ratio < 100 ? 1 : 0);
}

std::vector<std::string> StandingHeader() {
  return {"cost", "95_low", "95_high", "best", "equiv", "live", "lane"};
}

std::vector<std::string> StandingCells(const std::optional<ArmStanding>& standing) {
  if (!standing) return {"-", "-", "-", "-", "-", "-", "-"};
  const std::optional<CostRatio>& ratio = standing->cost_ratio;
  return {ratio ? RatioText(ratio->median) : "-",     ratio ? RatioText(ratio->low) : "-",
          ratio ? RatioText(ratio->high) : "-",       Fixed(standing->best_probability, 3),
          Fixed(standing->effective_window_count, 1), std::to_string(standing->live_window_count),
          std::to_string(standing->lane_visit_count)};
}

std::string StandingLegend() {
  return "cost: ratio to the leader's, with its 95 % interval; best: probability of being the best "
         "arm;\n"
         "live, lane: live windows and shadow-lane visits in the evidence; equiv: the number of "
         "live "
         "windows\nthat would be as informative as all of them and the priors; a few visits of the "
         "lane "
         "are less than 1\n";
}

void AddStanding(const std::optional<ArmStanding>& standing, Json& document) {
  const bool has_ratio = standing && standing->cost_ratio;
  document["cost_ratio"] = has_ratio ? Json(standing->cost_ratio->median) : Json();
  document["cost_ratio_95"] =
      has_ratio ? IntervalJson({standing->cost_ratio->low, standing->cost_ratio->high}) : Json();
  document["best_probability"] = standing ? Json(standing->best_probability) : Json();
  document["n"] = standing ? Json(standing->effective_window_count) : Json();
  document["live_windows"] = standing ? Json(standing->live_window_count) : Json();
  document["lane_visits"] = standing ? Json(standing->lane_visit_count) : Json();
}

}  // namespace sweepstake::cli
