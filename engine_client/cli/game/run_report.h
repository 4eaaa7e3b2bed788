// The output of `sweepstake run` during a run and at its end: text, JSON and CSV files. All
// functions except those that write files are pure.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "engine_client/cli/game/run_summary.h"
#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns "starts from priors of 3 earlier sessions", or that there are no priors and why.
std::string PriorsText(const RunSetup& setup, const SessionStats& session);
// Returns "12.3 s  frame 4567: SAP → KDTree (policy)".
std::string SwitchText(const SwitchRow& row);
// Returns "stable: KDTree is the best with probability 0.93".
std::string VerdictText(const VerdictRow& row);
// Returns "12.3 s  frame 4567: verdict stable: …".
std::string VerdictChangeText(const VerdictChangeRow& row);
// Returns the ratio of each arm's cost to the leader's, the best arm first, with the effective
// number of live windows: "KDTree ×1.00 (n 24.2) · Grid ×1.31 (6.0)". If the costs are unknown, it
// returns the posterior means instead: "KDTree 0.81 (n 24.2)". The text is empty if there are none
// yet.
std::string BeliefsText(std::span<const ArmBelief> beliefs);
// Returns the work and the cost of the shadow lane, or why there is none.
std::string ShadowText(const RunSummary& summary);
// Returns the detection time per frame, how much it saves compared with the median arm, and the
// shadow lane's time per frame.
std::string FrameCostText(const RunSummary& summary);
// Returns how many samples the full queue dropped, the cause according to the session's final
// state, and the consequence.
std::string DroppedText(const SessionStats& session, uint64_t frame_count);

// Returns the report at the end: a table of the arms and some lines.
std::string RunReportText(const RunSummary& summary);
nlohmann::ordered_json RunReportJson(const RunSummary& summary);
// Write the first line of frames.csv, and the line of a frame. Call WriteFrame between frames, so
// that its time does not count as frame time.
void WriteFrameHeader(WholeFile& csv);
void WriteFrame(const FrameSample& sample, const AdaptiveBroadPhase& adaptive, WholeFile& csv);
// Writes switches.csv and posteriors.csv into the existing `folder`. Error: kInvalidArgument (a
// file cannot be written).
Status WriteRunReportCsv(const RunSummary& summary, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
