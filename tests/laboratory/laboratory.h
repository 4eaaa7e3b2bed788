// The commands of the program `sweepstake-lab`, which measure and compare.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/commands.h"
#include "engine_client/cli/game/scene_choice.h"

namespace sweepstake::cli {

// Runs a command line of `sweepstake-lab`, as RunCommandLine does for `sweepstake`.
int RunLaboratory(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand, as in engine_client/cli/commands.h. `command_line` is what the
// user typed: the bench's report shows it, and the experiment's manifest keeps it.
void AddBenchCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                     int& exit_code);
void AddCheckCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddExperimentCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                          int& exit_code);
void AddLoadCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddPairsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddRecordCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddReplayCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddReportCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddTraceCommand(CLI::App& app, Terminal& terminal, int& exit_code);

// --scene, which is returned, and --objects for a list of scenes and object counts.
CLI::Option* AddSceneOptions(CLI::App& command, std::vector<std::string>& scenes,
                             std::vector<uint32_t>& object_counts);
// --arms.
void AddArmsOption(CLI::App& command, std::vector<std::string>& arms);
// --scene, which is required, --objects and --seed for one scene.
void AddSceneChoice(CLI::App& command, SceneChoice& scene);

}  // namespace sweepstake::cli
