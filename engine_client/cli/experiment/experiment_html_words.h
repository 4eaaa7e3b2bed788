// How the experiment's page says what it says: names, colours, figures. Pure functions, safe from
// any thread.
#pragma once

#include <string>
#include <vector>

#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/html/markup.h"

namespace sweepstake::cli {

// "Brownian 1,000".
std::string CellName(const ExperimentCell& cell);
// "adaptive" where "default" was asked for and stands for it: "AI Decides (adaptive)".
std::string PolicyTitle(const std::string& policy);

// The same in short, where there is little room: "AI Decides".
std::string PolicyShortName(const std::string& policy);

// The arms in the order of their colours.
std::vector<std::string> ArmKinds();
size_t ArmKind(const std::string& arm);
html::Markup ArmChip(const std::string& arm);
html::Markup ArmChip(const std::string& arm, const std::string& text);

// "+0.31 %", "−12.0 %", "0 %".
std::string PercentText(double ratio);
// "12.0 %", without a sign. REQUIRES: share >= 0.
std::string ShareText(double share);
// Microseconds with three digits: "14.2 µs".
std::string MicrosecondsText(double ns);

html::Markup Paragraph(const html::Markup& text);

}  // namespace sweepstake::cli
