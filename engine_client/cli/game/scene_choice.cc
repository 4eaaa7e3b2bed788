#include "engine_client/cli/game/scene_choice.h"

#include <algorithm>

#include "engine_client/scene/changing_scenes.h"
#include "engine_client/scene/degenerate_scenes.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kMixtureCount = 10;
constexpr std::string_view kMixture = "mixture";

bool IsOneOf(std::string_view name, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool IsFile(std::string_view name) { return name.ends_with(".aabbs"); }

std::vector<SceneChoice> ExpandName(const std::string& name, uint64_t seed) {
  std::vector<SceneChoice> choices;
  if (name == "all") {
    for (const std::string_view each : SceneNames())
      choices.push_back({std::string(each), 0, seed});
  } else if (name == "changing") {
    for (const std::string_view each : ChangingSceneNames())
      choices.push_back({std::string(each), 0, seed});
  } else if (name == "degenerate") {
    for (const std::string_view each : DegenerateSceneNames()) {
      if (each != kMixture) choices.push_back({std::string(each), 0, seed});
    }
  } else if (name == "mixtures") {
    for (uint64_t i = 0; i < kMixtureCount; ++i) {
      choices.push_back({std::string(kMixture), 0, seed + i});
    }
  } else {
    choices.push_back({name, 0, seed});
  }
  return choices;
}

// Names separated by commas, in lines of at most `columns` that start with `indent`.
std::string WrapNames(std::span<const std::string_view> names, const std::string& indent,
                      size_t columns) {
  std::string text = indent;
  size_t line = indent.size();
  for (const std::string_view name : names) {
    const bool first = name == names.front();
    if (!first && line + name.size() + 3 > columns) {
      text += ",\n" + indent;
      line = indent.size();
    } else if (!first) {
      text += ", ";
      line += 2;
    }
    text.append(name);
    line += name.size();
  }
  return text;
}

Status UnknownScene(const std::string& name) {
  std::string shown = name.substr(0, 200);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  constexpr size_t kOneLine = 1'000'000;
  return {StatusCode::kNotFound,
          "unknown scene '" + shown + "', must be one of " + WrapNames(SceneNames(), "", kOneLine) +
              ", " + WrapNames(ChangingSceneNames(), "", kOneLine) + ", " +
              WrapNames(DegenerateSceneNames(), "", kOneLine) + " or the path of a .aabbs file"};
}

}  // namespace

std::string SceneHelp() {
  return "SCENE is a FILE.aabbs, a scenario or a member of the reference suite\n" +
         WrapNames(SceneNames(), "  ", 80) +
         "\nor one in which the cheapest broad phase changes\n" +
         WrapNames(ChangingSceneNames(), "  ", 80) + "\nor one that is hard on broad phases\n" +
         WrapNames(DegenerateSceneNames(), "  ", 80) + ".\n";
}

std::vector<SceneChoice> ExpandScenes(const std::vector<std::string>& names,
                                      const std::vector<uint32_t>& object_counts, uint64_t seed) {
  std::vector<SceneChoice> choices;
  for (const std::string& name : names) {
    for (SceneChoice& choice : ExpandName(name, seed)) {
      for (const uint32_t object_count : object_counts) {
        choice.object_count = object_count;
        choices.push_back(choice);
        if (IsFile(choice.name)) break;
      }
    }
  }
  return choices;
}

Result<std::unique_ptr<Scene>> OpenScene(const SceneChoice& choice) {
  if (IsOneOf(choice.name, ChangingSceneNames())) {
    return MakeChangingScene(choice.name, choice.object_count, choice.seed);
  }
  if (!IsOneOf(choice.name, SceneNames()) && !IsFile(choice.name)) {
    if (!IsOneOf(choice.name, DegenerateSceneNames())) return UnknownScene(choice.name);
    return MakeDegenerateScene(choice.name, choice.object_count, choice.seed);
  }
  SceneOptions options;
  options.object_count = choice.object_count;
  options.spawn_seed = choice.seed;
  options.motion_seed = choice.seed;
  return MakeScene(choice.name, options);
}

Result<std::vector<std::string>> ChooseArms(const std::vector<std::string>& names) {
  const auto known = BroadPhaseNames();
  if (names.size() == 1 && names.front() == "all") {
    return std::vector<std::string>(known.begin(), known.end());
  }
  std::vector<std::string> arms;
  for (const std::string& name : names) {
    if (!IsOneOf(name, known)) return MakeBroadPhase(name).status();
    if (std::find(arms.begin(), arms.end(), name) == arms.end()) arms.push_back(name);
  }
  if (arms.empty())
    return Status(StatusCode::kInvalidArgument, "--arms needs at least one arm, or all");
  return arms;
}

}  // namespace sweepstake::cli
