#include "engine_client/cli/experiment/experiment_html_words.h"

#include <algorithm>
#include <cmath>

#include "engine_client/cli/experiment/experiment_tables.h"
#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

// Hundredths below 10 %, tenths below 100 %, whole ones above. REQUIRES: ratio >= 0.
std::string Percent(double ratio) {
  const double percent = 100 * ratio;
  if (percent < 9.995) return Fixed(percent, 2) + " %";
  if (percent < 99.95) return Fixed(percent, 1) + " %";
  return html::GroupedWhole(percent) + " %";
}

}  // namespace

std::string CellName(const ExperimentCell& cell) {
  return PaperSceneName(cell.scene) + " " + html::Grouped(cell.object_count);
}

std::string PolicyTitle(const std::string& policy) {
  const std::string own = OwnPolicyName("default");
  return OwnPolicyName(policy) == own ? "AI Decides (" + own + ")" : policy;
}

std::string PolicyShortName(const std::string& policy) {
  return OwnPolicyName(policy) == OwnPolicyName("default") ? "AI Decides" : policy;
}

std::vector<std::string> ArmKinds() {
  const auto names = BroadPhaseNames();
  return {names.begin(), names.end()};
}

size_t ArmKind(const std::string& arm) {
  const auto names = BroadPhaseNames();
  return static_cast<size_t>(std::find(names.begin(), names.end(), arm) - names.begin());
}

html::Markup ArmChip(const std::string& arm) { return ArmChip(arm, arm); }

html::Markup ArmChip(const std::string& arm, const std::string& text) {
  return html::AreaChip(ArmKind(arm), text);
}

std::string PercentText(double ratio) {
  const std::string size = Percent(std::abs(ratio));
  // What rounds to nothing has no sign.
  return size.find_first_not_of("0. %") == std::string::npos ? "0 %"
                                                             : (ratio < 0 ? "−" : "+") + size;
}

std::string ShareText(double share) { return Percent(share); }

std::string MicrosecondsText(double ns) { return html::Significant(ns * 1e-3, 3) + " µs"; }

html::Markup Paragraph(const html::Markup& text) { return html::Element("p", {}, text); }

}  // namespace sweepstake::cli
