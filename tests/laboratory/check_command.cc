// `sweepstake-lab check`: compares every arm with brute force, every frame, by pair identity.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "tests/laboratory/game/pair_oracle.h"
#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

constexpr size_t kShownPairs = 4;

struct CheckOptions {
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts{1000};
  uint64_t frames = 300;
  uint64_t seed = 1;
  std::vector<std::string> arms{"all"};
  bool json = false;
};

// The result of one arm in one scene.
struct Row {
  SceneChoice scene;
  ArmCheck check;

  bool passed() const { return !check.first_difference; }
};

Json PairsJson(const std::vector<OverlapPair>& pairs) {
  Json list = Json::array();
  for (const OverlapPair& pair : std::span(pairs).first(std::min(kShownPairs, pairs.size()))) {
    list.push_back({pair.a, pair.b});
  }
  return list;
}

Json RowJson(const Row& row) {
  Json json = {{"scene", row.scene.name},         {"objects", row.scene.object_count},
               {"seed", row.scene.seed},          {"arm", row.check.arm},
               {"frames", row.check.frame_count}, {"pairs", row.check.pair_count},
               {"passed", row.passed()}};
  if (const auto& first = row.check.first_difference) {
    json["first_difference"] = {{"frame", first->frame},
                                {"missing_count", first->pairs.missing.size()},
                                {"extra_count", first->pairs.extra.size()},
                                {"missing", PairsJson(first->pairs.missing)},
                                {"extra", PairsJson(first->pairs.extra)}};
  }
  return json;
}

std::string PairsText(const char* what, const std::vector<OverlapPair>& pairs) {
  if (pairs.empty()) return "";
  std::string text = "; " + std::to_string(pairs.size()) + " " + what + ":";
  for (const OverlapPair& pair : std::span(pairs).first(std::min(kShownPairs, pairs.size()))) {
    text += " (" + std::to_string(pair.a) + ", " + std::to_string(pair.b) + ")";
  }
  return text + (pairs.size() > kShownPairs ? " …" : "");
}

std::string FailureText(const Row& row) {
  const FirstDifference& first = *row.check.first_difference;
  return "FAILED " + row.check.arm + " in " + row.scene.name + " (" +
         std::to_string(row.scene.object_count) + " objects, seed " +
         std::to_string(row.scene.seed) + "): frame " + std::to_string(first.frame) +
         " is the first with other pairs" + PairsText("missing", first.pairs.missing) +
         PairsText("extra", first.pairs.extra) + '\n';
}

std::string RowsText(const std::vector<Row>& rows) {
  TextTable table({"scene", "objects", "seed", "arm", "frames", "pairs", "result"});
  for (const Row& row : rows) {
    table.AddRow({row.scene.name, std::to_string(row.scene.object_count),
                  std::to_string(row.scene.seed), row.check.arm,
                  std::to_string(row.check.frame_count), std::to_string(row.check.pair_count),
                  row.passed() ? "passed" : "FAILED"});
  }
  std::string text = table.Text();
  for (const Row& row : rows) {
    if (!row.passed()) text += FailureText(row);
  }
  return text;
}

Status CheckOne(SceneChoice choice, const std::vector<std::string>& arms, uint64_t frames,
                Progress& progress, std::vector<Row>& rows) {
  auto scene = OpenScene(choice);
  if (!scene.ok()) return scene.status();
  choice.object_count = static_cast<uint32_t>((*scene)->max_object_count());
  std::vector<std::unique_ptr<BroadPhase>> backends;
  backends.reserve(arms.size());
  for (const std::string& arm : arms) backends.push_back(std::move(*MakeBroadPhase(arm)));
  const std::string label = choice.name + ", " + std::to_string(choice.object_count) + " objects";
  const uint64_t first = rows.size() / arms.size() * (frames + 1);
  auto checks = CheckScene(**scene, backends, frames,
                           [&](uint64_t done) { progress.Show(first + done, label); });
  if (!checks.ok()) {
    return {checks.status().code(),
            label + ": " + checks.status().message() + "; use fewer --objects"};
  }
  for (ArmCheck& check : *checks) rows.push_back({choice, std::move(check)});
  return {};
}

int RunCheck(const CheckOptions& options, Terminal& terminal) {
  const auto arms = ChooseArms(options.arms);
  if (!arms.ok()) return Fail(terminal, arms.status());
  const auto scenes = ExpandScenes(options.scenes, options.object_counts, options.seed);
  std::vector<Row> rows;
  {
    Progress progress(terminal, "check", scenes.size() * (options.frames + 1));
    for (const SceneChoice& scene : scenes) {
      const Status status = CheckOne(scene, *arms, options.frames, progress, rows);
      if (!status.ok()) return Fail(terminal, status);
    }
  }
  const bool passed =
      std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.passed(); });
  Json document = {{"command", "check"}, {"passed", passed}, {"rows", Json::array()}};
  for (const Row& row : rows) document["rows"].push_back(RowJson(row));
  PrintResult(terminal, options.json, document, RowsText(rows));
  return passed ? kDone : kCheckFailed;
}

}  // namespace

void AddCheckCommand(const CommandContext& context) {
  AddCommand<CheckOptions>(
      context, "check", "Check in every frame that every arm finds the same pairs as brute force",
      "  sweepstake-lab check --scene suite-g --objects 1000,3000 --frames 300\n"
      "  sweepstake-lab check --scene all --arms DBVT,KDTree\n"
      "  sweepstake-lab check --scene degenerate --objects 300    empty, coincident, ±1e30, NaN, "
      "…\n"
      "  sweepstake-lab check --scene mixtures --seed 7           ten mixtures, seeds 7 to 16\n"
      "The exit code is 1 if an arm finds other pairs; the output shows the first such frame.\n"
      "The exit code is 2 if a frame has more than 20,000,000 pairs, too many to check.\n" +
          SceneHelp(),
      [](CLI::App& command, CheckOptions& options) {
        AddSceneOptions(command, options.scenes, options.object_counts)->required();
        AddArmsOption(command, options.arms);
        command.add_option("--frames", options.frames, "Frames to check after the first one")
            ->check(WholeUpTo(1'000'000));
        AddSeedOption(command, options.seed, "the scenes");
        AddJsonFlag(command, options.json);
      },
      RunCheck);
}

}  // namespace sweepstake::cli
