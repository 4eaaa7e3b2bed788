#include "engine_client/cli/game/scene_choice.h"

#include <algorithm>
#include <optional>

#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kMixtureCount = 10;
constexpr std::string_view kMixture = "mixture";

bool IsOneOf(std::string_view name, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool IsFile(std::string_view name) { return name.ends_with(".aabbs"); }

// Returns the group of scenes that the word stands for, if any.
std::optional<SceneGroup> GroupOf(std::string_view word) {
  if (word == "all") return SceneGroup::kReference;
  if (word == "changing") return SceneGroup::kChanging;
  if (word == "degenerate") return SceneGroup::kDegenerate;
  return std::nullopt;
}

std::vector<SceneChoice> ExpandName(const std::string& name, uint64_t seed) {
  std::vector<SceneChoice> choices;
  if (const auto group = GroupOf(name)) {
    for (const std::string_view each : SceneNames(*group)) {
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

// Returns the names separated by commas. Lines begin with `indent` and have at most `columns`
// characters.
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

}  // namespace

std::string SceneHelp() {
  return "SCENE is a FILE.aabbs, a scenario or a member of the reference suite\n" +
         WrapNames(SceneNames(SceneGroup::kReference), "  ", 80) +
         "\nor a scene in which the cheapest broad phase changes\n" +
         WrapNames(SceneNames(SceneGroup::kChanging), "  ", 80) +
         "\nor a degenerate scene, a bad case for some broad phases\n" +
         WrapNames(SceneNames(SceneGroup::kDegenerate), "  ", 80) + ".\n";
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
