#include "engine_client/cli/bench_command.h"

#include <nlohmann/json.hpp>

#include "engine_client/cli/json_output.h"
#include "engine_client/cli/scene_choice.h"
#include "engine_client/cli/scene_timing.h"
#include "engine_client/cli/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct BenchOptions {
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts{1000};
  uint64_t frames = 120;
  uint64_t warmup = 20;
  uint64_t seed = 1;
  std::vector<std::string> arms{"all"};
  uint32_t threads = 1;
  bool json = false;
};

struct Row {
  SceneChoice scene;
  std::string arm;
  ArmTiming timing;
};

Json RowJson(const Row& row) {
  return {{"scene", row.scene.name},
          {"objects", row.scene.object_count},
          {"arm", row.arm},
          {"threads", 1},
          {"frames", row.timing.frame_count},
          {"ms_median", row.timing.ms_median},
          {"ms_mean", row.timing.ms_mean},
          {"ms_min", row.timing.ms_min},
          {"ms_p99", row.timing.ms_p99},
          {"pairs_mean", row.timing.pairs_mean},
          {"aabb_checks_mean", row.timing.aabb_checks_mean},
          {"bytes", row.timing.bytes}};
}

void Print(const std::vector<Row>& rows, std::ostream& out) {
  TextTable table({"scene", "objects", "arm", "threads", "frames", "ms_median", "ms_mean", "ms_min",
                   "ms_p99", "pairs_mean", "aabb_checks_mean", "bytes"});
  for (const Row& row : rows) {
    const ArmTiming& timing = row.timing;
    table.AddRow({row.scene.name, std::to_string(row.scene.object_count), row.arm, "1",
                  std::to_string(timing.frame_count), Fixed(timing.ms_median, 4),
                  Fixed(timing.ms_mean, 4), Fixed(timing.ms_min, 4), Fixed(timing.ms_p99, 4),
                  Fixed(timing.pairs_mean, 1), Fixed(timing.aabb_checks_mean, 0),
                  std::to_string(timing.bytes)});
  }
  table.Print(out);
}

// Each arm gets a scene of its own, which one seed makes the same.
Result<Row> TimeArm(SceneChoice choice, const std::string& arm, const BenchOptions& options,
                    const std::function<void(uint64_t)>& on_frame) {
  auto scene = OpenScene(choice);
  if (!scene.ok()) return scene.status();
  auto backend = MakeBroadPhase(arm);
  if (!backend.ok()) return backend.status();
  choice.object_count = static_cast<uint32_t>((*scene)->aabbs().size());
  return Row{choice, arm, TimeScene(**scene, **backend, options.warmup, options.frames, on_frame)};
}

int RunBench(const BenchOptions& options, Terminal& terminal) {
  if (options.threads != 1) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument,
                                 "--threads takes 1: the backends run on one thread"));
  }
  const auto arms = ChooseArms(options.arms);
  if (!arms.ok()) return Fail(terminal, arms.status());
  const auto scenes = ExpandScenes(options.scenes, options.object_counts, options.seed, false);
  const uint64_t steps = options.warmup + options.frames;
  std::vector<Row> rows;
  {
    Progress progress(terminal, "bench", scenes.size() * arms->size() * steps);
    for (const SceneChoice& scene : scenes) {
      for (const std::string& arm : *arms) {
        const std::string label =
            scene.name + ", " + std::to_string(scene.object_count) + " objects, " + arm;
        auto row = TimeArm(scene, arm, options, [&](uint64_t step) {
          progress.Show(rows.size() * steps + step, label);
        });
        if (!row.ok()) return Fail(terminal, row.status());
        rows.push_back(std::move(*row));
      }
    }
  }
  if (options.json) {
    Json document = {{"command", "bench"},
                     {"warmup", options.warmup},
                     {"seed", options.seed},
                     {"rows", Json::array()}};
    for (const Row& row : rows) document["rows"].push_back(RowJson(row));
    PrintJson(document, terminal.out);
  } else {
    Print(rows, terminal.out);
  }
  return kDone;
}

void Declare(CLI::App& command, BenchOptions& options) {
  command.add_option("--scene", options.scenes, "Scenes or .aabbs files")
      ->delimiter(',')
      ->required();
  command.add_option("--objects", options.object_counts, "Object counts")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--frames", options.frames, "Measured frames")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1'000'000}))
      ->capture_default_str();
  command.add_option("--warmup", options.warmup, "Frames before them")
      ->check(WholeUpTo(1'000'000))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of the scenes")->capture_default_str();
  command.add_option("--arms", options.arms, "all, or names of backends")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--threads", options.threads, "Threads of each arm; 1")->capture_default_str();
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddBenchCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<BenchOptions>(
      app, "bench", "Time every arm on the same frames: take all boxes, find all pairs",
      "  sweepstake bench --scene suite-b,suite-g,suite-h --objects 1000,10000 --arms all\n"
      "  sweepstake bench --scene hurricane --objects 3000 --arms SAP,KDTree --json\n"
      "Milliseconds per frame; pairs and AABB checks are means per frame, bytes the most held.",
      exit_code, Declare,
      [&terminal](const BenchOptions& options) { return RunBench(options, terminal); });
}

}  // namespace sweepstake::cli
