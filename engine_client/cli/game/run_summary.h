// The result of `sweepstake run` as plain values, from which the report is made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/game/scene_choice.h"
#include "sweepstake/session.h"

namespace sweepstake::cli {

// The run's settings.
struct RunSetup {
  SceneChoice scene;
  std::string mode;
  std::string decider;      // HOST:PORT, or "embedded"
  std::string priors_file;  // may be empty
  std::string priors_key;   // describes the priors' project, scene and machine class
};

// One arm at the end of the run.
struct ArmRow {
  std::string arm;
  uint32_t backend_version = 0;
  ArmBelief belief;  // Beta(1,1) if the decider reported nothing
  ArmActivity activity;

  double mean() const;
  double active_s() const { return static_cast<double>(activity.active_ns) * 1e-9; }
  double fps() const;
  double detection_ms() const;  // per frame
};

struct SwitchRow {
  uint64_t frame_index = 0;
  double time_s = 0;  // since the run began
  std::string from;
  std::string to;
  SwitchReason reason = SwitchReason::kPolicy;
  // The next two values are 0 if the run ended before the switch had settled.
  uint64_t rebuild_time_ns = 0;
  uint64_t settling_cost_ns = 0;
  // If the switch ended a trial: the mean time of its searches (SwitchOutcome). Otherwise 0.
  uint64_t trial_detection_time_ns = 0;
};

// The decider's verdict about the scene; "unknown" before the first verdict.
struct VerdictRow {
  std::string name = "unknown";
  std::string leader_arm;  // empty: unknown
  double leader_probability = 0;
};

struct VerdictChangeRow {
  uint64_t frame_index = 0;
  double time_s = 0;
  VerdictRow verdict;
};

struct RunSummary {
  RunSetup setup;
  SessionStats session;
  ShadowStats shadow;
  uint64_t frame_count = 0;
  uint64_t suspended_frame_count = 0;  // frames with kFrameSuspended
  uint32_t invalid_box_count = 0;      // in the last frame
  std::string initial_arm;
  std::string active_arm;
  VerdictRow verdict;
  std::vector<ArmRow> arms;
  std::vector<SwitchRow> switches;
  std::vector<VerdictChangeRow> verdict_changes;

  // Returns the sum of all frame times.
  uint64_t active_ns() const;
  double active_s() const { return static_cast<double>(active_ns()) * 1e-9; }
  double fps() const;
  size_t SwitchCount(SwitchReason reason) const;
  // Returns the fraction of the run's time during which the shadow lane worked.
  double shadow_busy_ratio() const;
  double shadow_copy_ns_per_frame() const;
  // Returns the fraction of the frame thread's time that the lane cost, including the copying of
  // boxes. The lane measures that cost itself (ShadowStats::slowdown_time_ns).
  double shadow_frame_share() const;
  // Returns the lane's CPU time per frame. It is spent on another core than the frame thread's.
  double shadow_ms_per_frame() const;
  double detection_ms() const;  // per frame
};

RunSummary Summarize(const RunSetup& setup, const GameRun& run, const SessionStats& session);

SwitchRow ToRow(const SwitchEvent& event, const AdaptiveBroadPhase& adaptive);
VerdictRow ToRow(const SceneVerdict& verdict, const AdaptiveBroadPhase& adaptive);
VerdictChangeRow ToRow(const VerdictEvent& event, const AdaptiveBroadPhase& adaptive);

}  // namespace sweepstake::cli
