// Writes what `sweepstake run` says while it runs and at its end: text, JSON and CSV files. All
// functions but the last are pure.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "engine_client/cli/game/run_summary.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// "starts from priors of 3 earlier sessions", or that there are none, and where there are none.
std::string PriorsText(const RunSetup& setup, const SessionStats& session);
// "12.3 s  frame 4567: SAP → KDTree (policy)".
std::string SwitchText(const SwitchRow& row);
// "stable: KDTree is the best with probability 0.93".
std::string VerdictText(const VerdictRow& row);
// "12.3 s  frame 4567: verdict stable: …".
std::string VerdictChangeText(const VerdictChangeRow& row);
// The posterior means, the best first, with alpha + beta: "KDTree 0.81 (n 24) · Grid 0.73 (6)".
// Empty when there are none yet.
std::string BeliefsText(std::span<const ArmBelief> beliefs);
// What the shadow lane has done and what it cost, or why there is none.
std::string ShadowText(const RunSummary& summary);
// How many samples the full queue dropped, and what that means.
std::string DroppedText(uint64_t dropped_count, uint64_t frame_count);

// The report at the end: a table of the arms, and lines.
std::string RunReportText(const RunSummary& summary);
nlohmann::ordered_json RunReportJson(const RunSummary& summary);
// Writes switches.csv and posteriors.csv in `folder`, which exists. kInvalidArgument: a file cannot
// be written.
Status WriteRunReportCsv(const RunSummary& summary, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
