// The output of `sweepstake run` during a run and at its end, as text, JSON and CSV files. All
// functions are pure except the ones that write files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "engine_client/cli/game/run_summary.h"
#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns, for example, "starts from priors of 3 earlier sessions". Without priors, the text gives
// the reason.
std::string PriorsText(const RunSetup& setup, const SessionStats& session);
// Returns, for example, "12.3 s  frame 4567: SAP → KDTree (policy)".
std::string SwitchText(const SwitchRow& row);
// Returns, for example, "stable: KDTree is the best with probability 0.93".
std::string VerdictText(const VerdictRow& row);
// Returns, for example, "12.3 s  frame 4567: verdict stable: …".
std::string VerdictChangeText(const VerdictChangeRow& row);
// Returns each arm's cost ÷ the leader's cost, the best arm first, with the equivalent number of
// live windows: "KDTree ×1.00 (24.2 equivalent windows) · Grid ×1.31 (6.0)". If the costs are
// unknown, returns the posterior means: "KDTree 0.81 (24.2 equivalent windows)". Empty if there are
// no beliefs yet.
std::string BeliefsText(std::span<const ArmBelief> beliefs);
// Returns the work and the cost of the shadow lane as text, or the reason why there is no lane.
std::string ShadowText(const RunSummary& summary);
// Returns the detection time per frame, the saving against always running the initial arm, and the
// shadow lane's time per frame.
std::string FrameCostText(const RunSummary& summary);
// Returns a warning: how many frames the full queue dropped, why (according to the final state of
// the session), and the consequences.
std::string DroppedText(const SessionStats& session, uint64_t frame_count);

// Returns the report at the end of a run: a table of the arms and some lines.
std::string RunReportText(const RunSummary& summary);
nlohmann::ordered_json RunReportJson(const RunSummary& summary);
// Write the header line of frames.csv, and the line of one frame. Call WriteFrame between frames,
// so that the time for writing is not part of a frame time.
void WriteFrameHeader(WholeFile& csv);
void WriteFrame(const FrameSample& sample, const AdaptiveBroadPhase& adaptive, WholeFile& csv);
// Writes switches.csv and posteriors.csv into `folder`, which must exist. Error: kInvalidArgument
// if a file cannot be written.
Status WriteRunReportCsv(const RunSummary& summary, const std::filesystem::path& folder);

}  // namespace sweepstake::cli
