// The commands of the program `sweepstake-lab`, which measure and compare.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/decider/options.h"

namespace sweepstake::cli {

// Runs a command line of `sweepstake-lab`, as RunCommandLine does for `sweepstake`.
int RunLaboratory(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand, as in engine_client/cli/commands.h.
void AddBenchCommand(const CommandContext& context);
void AddCheckCommand(const CommandContext& context);
void AddExperimentCommand(const CommandContext& context);
void AddLoadCommand(const CommandContext& context);
void AddPairsCommand(const CommandContext& context);
void AddRecordCommand(const CommandContext& context);
void AddReplayCommand(const CommandContext& context);
void AddReportCommand(const CommandContext& context);
void AddTraceCommand(const CommandContext& context);

// Adds --scene (returned) and --objects, for commands with lists of scenes and object counts.
CLI::Option* AddSceneOptions(CLI::App& command, std::vector<std::string>& scenes,
                             std::vector<uint32_t>& object_counts);
// Adds --arms.
void AddArmsOption(CLI::App& command, std::vector<std::string>& arms);
// Adds --scene (required), --objects and --seed, for commands with one scene.
void AddSceneChoice(CLI::App& command, SceneChoice& scene);

// Returns "1 h 12 min", "3 min" or "40 s".
std::string DurationText(double seconds);

// Returns a callback that shows the finished share, its text and an estimate of the remaining time.
// The estimate assumes the mean speed since OnShareWithTimeLeft was called. REQUIRES: `progress`
// outlives the callback.
std::function<void(double share, const std::string& text)> OnShareWithTimeLeft(Progress& progress);

}  // namespace sweepstake::cli
