#include "tests/laboratory/laboratory.h"

#include <chrono>
#include <cmath>

namespace sweepstake::cli {
namespace {

void AddCommands(const CommandContext& context) {
  AddCheckCommand(context);
  AddBenchCommand(context);
  AddExperimentCommand(context);
  AddLoadCommand(context);
  AddPairsCommand(context);
  AddRecordCommand(context);
  AddReplayCommand(context);
  AddReportCommand(context);
  AddTraceCommand(context);
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
      ->check(WholeUpTo(kMaxSceneObjectCount));
  return command
      .add_option("--scene", scenes,
                  "Scenes, .aabbs files, or groups: all, changing, degenerate, mixtures")
      ->delimiter(',');
}

void AddArmsOption(CLI::App& command, std::vector<std::string>& arms) {
  command.add_option("--arms", arms, "Names of backends, or all")->delimiter(',');
}

void AddSceneChoice(CLI::App& command, SceneChoice& scene) {
  command.add_option("--scene", scene.name, "Scene or .aabbs file")->required();
  command.add_option("--objects", scene.object_count,
                     "Object count; ignored for a file, which has its own");
  AddSeedOption(command, scene.seed, "spawn and motion");
}

std::string DurationText(double seconds) {
  const auto whole = [](double value) { return std::to_string(std::lround(value)); };
  if (seconds < 90) return whole(seconds) + " s";
  const double minutes = std::round(seconds / 60);
  if (minutes < 90) return whole(minutes) + " min";
  return whole(std::floor(minutes / 60)) + " h " + whole(std::fmod(minutes, 60)) + " min";
}

std::function<void(double share, const std::string& text)> OnShareWithTimeLeft(Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  return [&progress, start](double share, const std::string& text) {
    if (!progress.due() || share <= 0) return;
    const std::chrono::duration<double> used = std::chrono::steady_clock::now() - start;
    progress.OnShare()(share,
                       text + ", " + DurationText(used.count() / share * (1 - share)) + " left");
  };
}

}  // namespace sweepstake::cli
