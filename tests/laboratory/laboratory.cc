#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

void AddCommands(CLI::App& app, Terminal& terminal, const std::string& command_line,
                 int& exit_code) {
  AddCheckCommand(app, terminal, exit_code);
  AddBenchCommand(app, terminal, command_line, exit_code);
  AddExperimentCommand(app, terminal, command_line, exit_code);
  AddLoadCommand(app, terminal, exit_code);
  AddPairsCommand(app, terminal, exit_code);
  AddRecordCommand(app, terminal, exit_code);
  AddReplayCommand(app, terminal, exit_code);
  AddReportCommand(app, terminal, exit_code);
  AddTraceCommand(app, terminal, exit_code);
}

}  // namespace

int RunLaboratory(std::span<char* const> words, Terminal& terminal) {
  return RunProgram({.name = "sweepstake-lab",
                     .description = "Sweepstake's laboratory: measures broad phases and policies",
                     .add_commands = AddCommands},
                    words, terminal);
}

CLI::Option* AddSceneOptions(CLI::App& command, std::vector<std::string>& scenes,
                             std::vector<uint32_t>& object_counts) {
  command.add_option("--objects", object_counts, "Object counts")
      ->delimiter(',')
      ->check(WholeUpTo(kMaxSceneObjectCount))
      ->capture_default_str();
  return command
      .add_option("--scene", scenes,
                  "Scenes or .aabbs files, or all, changing, degenerate, mixtures")
      ->delimiter(',');
}

void AddArmsOption(CLI::App& command, std::vector<std::string>& arms) {
  command.add_option("--arms", arms, "all, or names of backends")
      ->delimiter(',')
      ->capture_default_str();
}

void AddSceneChoice(CLI::App& command, SceneChoice& scene) {
  command.add_option("--scene", scene.name, "Scene or .aabbs file")->required();
  command.add_option("--objects", scene.object_count, "Object count; a file has its own")
      ->capture_default_str();
  AddSeedOption(command, scene.seed, "spawn and motion");
}

}  // namespace sweepstake::cli
