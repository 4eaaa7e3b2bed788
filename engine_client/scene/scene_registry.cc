// The interface's functions and the only list of all scenes. To add a scene, add a line here.
#include <algorithm>
#include <array>
#include <filesystem>
#include <locale>
#include <optional>
#include <sstream>
#include <string>

#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/changing_scenes.h"
#include "engine_client/scene/recorded_scene.h"
#include "engine_client/scene/scenarios.h"
#include "engine_client/scene/suite_scene.h"
#include "engine_client/scene/utf8_path.h"
#include "engine_client/text/names.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

using ScenePointer = std::unique_ptr<Scene>;

struct Entry {
  SceneDescription description;
  bool uses_all_options;  // false: uses only the object count and perhaps spawn_seed
  ScenePointer (*make)(std::string_view name, const SceneOptions& options);
};

template <ScenePointer (*make)(const SceneOptions&)>
constexpr Entry Scenario(std::string_view name, std::string_view summary) {
  return {{name, SceneGroup::kReference, summary},
          true,
          [](std::string_view, const SceneOptions& options) { return make(options); }};
}

template <ScenePointer (*make)(uint32_t)>
constexpr Entry Suite(std::string_view name, std::string_view summary) {
  return {{name, SceneGroup::kReference, summary},
          false,
          [](std::string_view, const SceneOptions& options) { return make(options.object_count); }};
}

constexpr Entry Changing(std::string_view name, std::string_view summary) {
  return {{name, SceneGroup::kChanging, summary},
          false,
          [](std::string_view scene, const SceneOptions& options) {
            return MakeChangingScene(scene, options.object_count, options.spawn_seed);
          }};
}

constexpr Entry Degenerate(std::string_view name, std::string_view summary) {
  return {{name, SceneGroup::kDegenerate, summary},
          false,
          [](std::string_view scene, const SceneOptions& options) {
            return MakeDegenerateScene(scene, options.object_count, options.spawn_seed);
          }};
}

// The scenes are sorted by group, in the order of SceneGroup.
constexpr std::array kEntries = {
    Scenario<MakeBrownian>("brownian", "independent random kicks"),
    Scenario<MakeRotatingGravity>("rotating-gravity", "gravity in four directions in turn"),
    Scenario<MakeHurricane>("hurricane", "orbits around the vertical axis"),
    Scenario<MakeFreeFall>("free-fall", "bodies fall and come to rest"),
    Scenario<MakeRandomGravity>("random-gravity", "each body falls in its own direction"),
    Suite<MakeSuiteBrownian>("suite-b", "reference suite: random kicks"),
    Suite<MakeSuiteGravity>("suite-g", "reference suite: rotating gravity"),
    Suite<MakeSuiteHurricane>("suite-h", "reference suite: orbits"),
    Changing("rest-and-motion", "near rest, then random kicks"),
    Changing("waves", "few objects, then all at random places, then all near rest"),
    Changing("storms", "a third of the objects jump anywhere, then random kicks"),
    Changing("gather-and-scatter", "contracts, rests, expands, rests"),
    Changing("day-and-night", "orbits, then one object in a hundred moves"),
    Changing("arrivals", "objects come and go, then rest, then flow"),
    Degenerate("empty", "no objects"),
    Degenerate("one", "one object"),
    Degenerate("two", "two objects that touch"),
    Degenerate("count-changing", "a mixture whose object count changes in every frame"),
    Degenerate("spawning", "a 64th of the objects comes or goes in every frame"),
    Degenerate("nearly-resting", "every box moves by up to ±0.001"),
    Degenerate("few-moving", "one box in a hundred moves"),
    Degenerate("falling", "everything lands on one floor"),
    Degenerate("all-coincident", "every box is the same"),
    Degenerate("all-disjoint", "no boxes overlap"),
    Degenerate("touching-faces", "faces, edges and corners meet exactly"),
    Degenerate("zero-size", "points and lines"),
    Degenerate("one-huge", "one box overlaps most others"),
    Degenerate("coordinates-1e30", "coordinates around 1e30"),
    Degenerate("float-limits", "denormal and maximum floats"),
    Degenerate("signed-zeros", "faces at -0 and +0"),
    Degenerate("teleporting", "a third of the boxes jump anywhere"),
    Degenerate("broken-boxes", "NaN, infinite and inverted boxes"),
    Degenerate("long-thin", "lengths of half the world and more"),
    Degenerate("beams", "aspect ratios of 1:10 to 1:160"),
    Degenerate("clusters", "seven dense groups"),
    Degenerate("planar", "all boxes on one plane"),
    Degenerate("sizes-1-to-1000", "sizes over three decades"),
    Degenerate("far-crowds", "two crowds 10,000 units apart"),
    Degenerate("exponential-spacing", "distances and sizes over nine decades"),
    Degenerate("mixture", "every box is of a random kind"),
};

constexpr auto kDescriptions = [] {
  std::array<SceneDescription, kEntries.size()> descriptions;
  for (size_t i = 0; i < descriptions.size(); ++i) descriptions[i] = kEntries[i].description;
  return descriptions;
}();

constexpr auto kNames = [] {
  std::array<std::string_view, kEntries.size()> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kEntries[i].description.name;
  return names;
}();

constexpr bool IsBefore(const SceneDescription& left, const SceneDescription& right) {
  return left.group < right.group;
}
static_assert(std::is_sorted(kDescriptions.begin(), kDescriptions.end(), IsBefore));

template <typename T>
Status OutOfRange(const char* name, T min, T max, T value) {
  std::ostringstream message;
  message.imbue(std::locale::classic());
  message << name << " must be from " << min << " to " << max << ", not " << value;
  return {StatusCode::kInvalidArgument, message.str()};
}

// Checks the ranges of the options. A value that is not finite is out of every range.
Status ValidateFloats(const SceneOptions& options) {
  const struct {
    const char* name;
    float value;
    float min;
    float max;
  } ranges[] = {
      {"world_half_extent", options.world_half_extent, 1e-3F, 1e6F},
      {"fixed_step_s", options.fixed_step_s, 1e-6F, 1},
      {"half_extent_min", options.half_extent_min, 1e-6F, options.world_half_extent},
      {"half_extent_max", options.half_extent_max, options.half_extent_min,
       options.world_half_extent},
      {"speed", options.speed, 0, 1e6F},
      {"gravity", options.gravity, 0, 1e6F},
      {"direction_interval_s", options.direction_interval_s, 1e-6F, 1e6F},
  };
  for (const auto& [name, value, min, max] : ranges) {
    const bool in_range = value >= min && value <= max;
    if (!in_range) return OutOfRange(name, min, max, value);
  }
  return {};
}

Result<ScenePointer> MakeEntry(const Entry& entry, const SceneOptions& options) {
  if (options.object_count > kMaxSceneObjectCount) {
    return OutOfRange<uint32_t>("object_count", 0, kMaxSceneObjectCount, options.object_count);
  }
  if (entry.uses_all_options) {
    if (Status status = ValidateFloats(options); !status.ok()) return status;
  }
  return entry.make(entry.description.name, options);
}

Status UnknownScene(std::string_view scene) {
  return {StatusCode::kNotFound,
          text::UnknownName("scene", scene, kNames) + ", or the path of a .aabbs file"};
}

Result<ScenePointer> MakeNamedScene(std::string_view scene, const SceneOptions& options) {
  for (const Entry& entry : kEntries) {
    if (entry.description.name == scene) return MakeEntry(entry, options);
  }
  const std::optional<std::filesystem::path> path = PathOfUtf8(scene);
  if (path && path->extension() == ".aabbs") return RecordedScene::Open(*path);
  return UnknownScene(scene);
}

}  // namespace

void Scene::Step() {
  const FloatEnvironmentScope scope;
  DoStep();
}

std::span<const SceneDescription> SceneDescriptions() { return kDescriptions; }

std::span<const std::string_view> SceneNames() { return kNames; }

std::span<const std::string_view> SceneNames(SceneGroup group) {
  const auto [first, last] = std::equal_range(kDescriptions.begin(), kDescriptions.end(),
                                              SceneDescription{{}, group, {}}, IsBefore);
  return std::span(kNames).subspan(static_cast<size_t>(first - kDescriptions.begin()),
                                   static_cast<size_t>(last - first));
}

Result<std::unique_ptr<Scene>> MakeScene(std::string_view scene, const SceneOptions& options) {
  const FloatEnvironmentScope environment;
  return CatchOutOfMemory([&] { return MakeNamedScene(scene, options); },
                          [] {
                            return Status(StatusCode::kResourceExhausted,
                                          "not enough memory for the scene: choose a smaller "
                                          "object_count or file");
                          });
}

Result<std::string> RecordedNotes(std::string_view path) {
  const std::optional<std::filesystem::path> file = PathOfUtf8(path);
  if (!file) {
    return Status(StatusCode::kNotFound,
                  "'" + text::PrintableLine(path) + "' is not a path in UTF-8");
  }
  return RecordedScene::NotesOf(*file);
}

}  // namespace sweepstake
