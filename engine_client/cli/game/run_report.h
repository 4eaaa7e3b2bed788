// What `sweepstake run` says while it runs, and in the end: for people, as JSON, and as CSV files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <span>
#include <string>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/game/scene_choice.h"
#include "sweepstake/session.h"

namespace sweepstake::cli {

// How the run was asked for.
struct RunSetup {
  SceneChoice scene;
  std::string mode;
  std::string decider;      // HOST:PORT, or "embedded"
  std::string priors_file;  // empty: none
  std::string priors_key;   // what priors were looked for under, in words
};

// "starts from priors of 3 earlier sessions", or that there are none, and where there are none.
std::string PriorsText(const RunSetup& setup, const SessionStats& stats);
// "12.3 s  frame 4567: SAP → KDTree (policy)".
std::string SwitchText(const SwitchEvent& event, const AdaptiveBroadPhase& adaptive);
// "stable: KDTree is the best with probability 0.93".
std::string VerdictText(const SceneVerdict& verdict, const AdaptiveBroadPhase& adaptive);
// The same with when: "12.3 s  frame 4567: verdict stable: …".
std::string VerdictChangeText(const VerdictEvent& event, const AdaptiveBroadPhase& adaptive);
// The posterior means, best first, with alpha + beta: "KDTree 0.81 (n 24) · Grid 0.73 (6)". Empty
// when there are none yet.
std::string BeliefsText(std::span<const ArmBelief> beliefs);
// What the shadow lane has done and what it cost, or why there is none.
std::string ShadowText(const ShadowStats& stats, uint64_t frame_count, uint64_t elapsed_ns);
// How many samples the full queue dropped, and what that means.
std::string DroppedText(uint64_t dropped_count, uint64_t frame_count);

void PrintRunReport(const RunSetup& setup, const GameRun& run, const SessionStats& stats,
                    std::ostream& out);
nlohmann::ordered_json RunReportJson(const RunSetup& setup, const GameRun& run,
                                     const SessionStats& stats);
// switches.csv and posteriors.csv in `folder`, which exists.
Status WriteRunReportCsv(const GameRun& run, const SessionStats& stats,
                         const std::filesystem::path& folder);

}  // namespace sweepstake::cli
