#include "tests/laboratory/laboratory.h"

#include <chrono>
#include <cmath>

#include "engine_client/cli/io/duration.h"

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

void AddInterval(CLI::App& command, const char* name, int64_t& interval_ns, const char* help) {
  command
      .add_option_function<std::string>(
          name,
          [name, &interval_ns](const std::string& text) {
            const auto duration_ns = ParseDuration(text);
            if (!duration_ns.ok()) throw CLI::ValidationError(name, duration_ns.status().message());
            interval_ns = static_cast<int64_t>(*duration_ns);
          },
          help)
      ->type_name("DURATION");
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

void AddDecisionOptions(CLI::App& command, decision::DecisionOptions& options) {
  AddInterval(command, "--interval", options.decision_interval_ns,
              "Time between two decisions (default: 2s)");
  AddInterval(command, "--cooldown", options.cooldown_ns,
              "Minimum time between two switches; some policies wait less (default: 40s)");
  AddInterval(command, "--settling", options.settling_ns,
              "Frame time after a switch that is excluded from learning (default: 2s)");
  command
      .add_option_function<std::vector<double>>(
          "--weights",
          [&weights = options.weights](const std::vector<double>& given) {
            if (given.size() != 4) {
              throw CLI::ValidationError("--weights",
                                         "give four numbers, such as 0.55,0.25,0.12,0.08");
            }
            weights = {given[0], given[1], given[2], given[3]};
          },
          "Weights of the paper's reward, whose sum is 1: frame rate, detection time, memory, "
          "checks (default: 0.55,0.25,0.12,0.08)")
      ->delimiter(',')
      ->type_name("W,W,W,W");
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
