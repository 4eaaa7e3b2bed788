#include "engine_client/cli/bench_command.h"

#include <map>
#include <memory>
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
  std::vector<uint32_t> thread_counts{1};
  bool json = false;
};

struct Row {
  SceneChoice scene;
  std::string arm;
  uint32_t thread_count;
  ArmTiming timing;
};

// The pools of a run, one per count of threads; a count of 1 does without.
class ThreadPools {
 public:
  explicit ThreadPools(const std::vector<uint32_t>& thread_counts) {
    for (const uint32_t count : thread_counts) {
      if (count > 1 && !pools_.contains(count)) pools_[count] = MakeThreadPool(count);
    }
  }
  Executor* Of(uint32_t thread_count) const {
    const auto pool = pools_.find(thread_count);
    return pool == pools_.end() ? nullptr : pool->second.get();
  }

 private:
  std::map<uint32_t, std::unique_ptr<Executor>> pools_;
};

Json RowJson(const Row& row) {
  return {{"scene", row.scene.name},
          {"objects", row.scene.object_count},
          {"arm", row.arm},
          {"threads", row.thread_count},
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
    table.AddRow({row.scene.name, std::to_string(row.scene.object_count), row.arm,
                  std::to_string(row.thread_count), std::to_string(timing.frame_count),
                  Fixed(timing.ms_median, 4), Fixed(timing.ms_mean, 4), Fixed(timing.ms_min, 4),
                  Fixed(timing.ms_p99, 4), Fixed(timing.pairs_mean, 1),
                  Fixed(timing.aabb_checks_mean, 0), std::to_string(timing.bytes)});
  }
  table.Print(out);
}

// Each arm gets a scene of its own, which one seed makes the same.
Result<Row> TimeArm(SceneChoice choice, const std::string& arm, uint32_t thread_count,
                    const ThreadPools& pools, const BenchOptions& options,
                    const std::function<void(uint64_t)>& on_frame) {
  auto scene = OpenScene(choice);
  if (!scene.ok()) return scene.status();
  auto backend = MakeBroadPhase(arm, {.executor = pools.Of(thread_count)});
  if (!backend.ok()) return backend.status();
  choice.object_count = static_cast<uint32_t>((*scene)->aabbs().size());
  return Row{choice, arm, thread_count,
             TimeScene(**scene, **backend, options.warmup, options.frames, on_frame)};
}

int RunBench(const BenchOptions& options, Terminal& terminal) {
  const auto arms = ChooseArms(options.arms);
  if (!arms.ok()) return Fail(terminal, arms.status());
  const auto scenes = ExpandScenes(options.scenes, options.object_counts, options.seed);
  const uint64_t steps = options.warmup + options.frames;
  const ThreadPools pools(options.thread_counts);
  std::vector<Row> rows;
  {
    Progress progress(terminal, "bench",
                      scenes.size() * arms->size() * options.thread_counts.size() * steps);
    for (const SceneChoice& scene : scenes) {
      for (const std::string& arm : *arms) {
        for (const uint32_t threads : options.thread_counts) {
          const std::string label = scene.name + ", " + std::to_string(scene.object_count) +
                                    " objects, " + arm + ", " + std::to_string(threads) +
                                    " threads";
          auto row = TimeArm(scene, arm, threads, pools, options, [&](uint64_t step) {
            progress.Show(rows.size() * steps + step, label);
          });
          if (!row.ok()) return Fail(terminal, row.status());
          rows.push_back(std::move(*row));
        }
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
  command
      .add_option("--scene", options.scenes, "Scenes or .aabbs files, or all, degenerate, mixtures")
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
  command.add_option("--threads", options.thread_counts, "Threads of each arm, counted one by one")
      ->delimiter(',')
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddBenchCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  AddCommand<BenchOptions>(
      app, "bench", "Time every arm on the same frames: take all boxes, find all pairs",
      "  sweepstake bench --scene suite-b,suite-g,suite-h --objects 1000,10000 --arms all\n"
      "  sweepstake bench --scene hurricane --objects 3000 --arms SAP,KDTree --json\n"
      "  sweepstake bench --scene nearly-resting,beams --objects 10000 --threads 1,2\n"
      "Milliseconds per frame; pairs and AABB checks are means per frame, bytes the most held.\n" +
          SceneHelp(),
      exit_code, Declare,
      [&terminal](const BenchOptions& options) { return RunBench(options, terminal); });
}

}  // namespace sweepstake::cli
