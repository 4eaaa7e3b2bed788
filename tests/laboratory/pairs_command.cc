// `sweepstake-lab pairs`: the overlap pairs of one frame, as one arm finds them.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/json_output.h"
#include "sweepstake/broad_phase.h"
#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

struct PairsOptions {
  SceneChoice scene{"", 1000, 1};
  uint64_t frame = 0;
  std::string arm;
  bool json = false;
};

// Runs the arm on all frames up to `frame`. Its pairs then result from incremental updates, as in a
// game, and not from a first build.
PairBuffer FindPairsOfFrame(Scene& scene, BroadPhase& arm, uint64_t frame) {
  PairBuffer pairs;
  arm.Build(scene.aabbs());
  for (uint64_t i = 0; i < frame; ++i) {
    arm.FindPairs(pairs);
    pairs.Clear();
    scene.Step();
    arm.Update(scene.aabbs());
  }
  arm.FindPairs(pairs);
  std::sort(pairs.pairs().begin(), pairs.pairs().end());
  return pairs;
}

nlohmann::ordered_json PairsJson(const PairsOptions& options, const PairBuffer& pairs) {
  nlohmann::ordered_json document = {{"command", "pairs"},
                                     {"scene", options.scene.name},
                                     {"frame", options.frame},
                                     {"arm", options.arm},
                                     {"pairs", nlohmann::ordered_json::array()}};
  for (const OverlapPair& pair : pairs.pairs()) document["pairs"].push_back({pair.a, pair.b});
  return document;
}

std::string PairsText(const PairBuffer& pairs) {
  std::string text;
  for (const OverlapPair& pair : pairs.pairs()) {
    text += std::to_string(pair.a) + ' ' + std::to_string(pair.b) + '\n';
  }
  return text;
}

int RunPairs(const PairsOptions& options, Terminal& terminal) {
  auto arm = MakeBroadPhase(options.arm);
  if (!arm.ok()) return Fail(terminal, arm.status());
  auto scene = OpenScene(options.scene);
  if (!scene.ok()) return Fail(terminal, scene.status());
  const PairBuffer pairs = FindPairsOfFrame(**scene, **arm, options.frame);
  constexpr int kOneLine = -1;
  PrintResult(terminal, options.json, PairsJson(options, pairs), PairsText(pairs), kOneLine);
  return kDone;
}

}  // namespace

void AddPairsCommand(const CommandContext& context) {
  AddCommand<PairsOptions>(
      context, "pairs",
      "Print the overlapping pairs of one frame, sorted, as a line \"a b\" for each pair",
      "  sweepstake-lab pairs --scene h.aabbs --frame 10 --arm Tracy\n"
      "  sweepstake-lab pairs --scene suite-b --objects 1000 --frame 21 --arm BruteForce\n"
      "Frame 0 has the initial boxes. A recorded file starts again after its last frame.\n" +
          SceneHelp(),
      [](CLI::App& command, PairsOptions& options) {
        AddSceneChoice(command, options.scene);
        command.add_option("--frame", options.frame, "Frame to show")
            ->check(WholeUpTo(1'000'000))
            ->required();
        command.add_option("--arm", options.arm, "Backend that finds the pairs")->required();
        AddJsonFlag(command, options.json);
      },
      RunPairs);
}

}  // namespace sweepstake::cli
