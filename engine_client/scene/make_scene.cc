#include <array>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>

#include "engine_client/scene/aabbs_format.h"
#include "engine_client/scene/brownian_scene.h"
#include "engine_client/scene/falling_scene.h"
#include "engine_client/scene/hurricane_scene.h"
#include "engine_client/scene/recorded_scene.h"
#include "engine_client/scene/scene_options.h"
#include "engine_client/scene/suite_scene.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

using ScenePointer = std::unique_ptr<Scene>;

struct Scenario {
  std::string_view name;
  ScenePointer (*make)(const SceneOptions&);
};

// Scenarios obey every option, the suite only the object count.
constexpr std::array<Scenario, 5> kScenarios{{
    {"brownian",
     [](const SceneOptions& o) -> ScenePointer { return std::make_unique<BrownianScene>(o); }},
    {"rotating-gravity",
     [](const SceneOptions& o) -> ScenePointer { return FallingScene::RotatingGravity(o); }},
    {"hurricane",
     [](const SceneOptions& o) -> ScenePointer { return std::make_unique<HurricaneScene>(o); }},
    {"free-fall", [](const SceneOptions& o) -> ScenePointer { return FallingScene::FreeFall(o); }},
    {"random-gravity",
     [](const SceneOptions& o) -> ScenePointer { return FallingScene::RandomGravity(o); }},
}};

struct SuiteMember {
  std::string_view name;
  ScenePointer (*make)(uint32_t object_count);
};

constexpr std::array<SuiteMember, 3> kSuite{{
    {"suite-b", [](uint32_t n) -> ScenePointer { return std::make_unique<SuiteBrownian>(n); }},
    {"suite-g", [](uint32_t n) -> ScenePointer { return std::make_unique<SuiteGravity>(n); }},
    {"suite-h", [](uint32_t n) -> ScenePointer { return std::make_unique<SuiteHurricane>(n); }},
}};

constexpr auto kNames = [] {
  std::array<std::string_view, kScenarios.size() + kSuite.size()> names;
  for (size_t i = 0; i < kScenarios.size(); ++i) names[i] = kScenarios[i].name;
  for (size_t i = 0; i < kSuite.size(); ++i) names[kScenarios.size() + i] = kSuite[i].name;
  return names;
}();

Status UnknownScene(std::string_view scene) {
  std::string message = "unknown scene '" + aabbs::OneLine(scene) + "', must be one of";
  for (const std::string_view name : kNames) message.append(" ").append(name).append(",");
  return {StatusCode::kNotFound, message + " or the path of a .aabbs file"};
}

Result<ScenePointer> MakeScenario(const Scenario& scenario, const SceneOptions& options) {
  if (Status status = ValidateSceneOptions(options); !status.ok()) return status;
  return scenario.make(options);
}

Result<ScenePointer> MakeSuiteMember(const SuiteMember& member, uint32_t object_count) {
  if (Status status = ValidateObjectCount(object_count); !status.ok()) return status;
  return member.make(object_count);
}

Result<ScenePointer> MakeNamedScene(std::string_view scene, const SceneOptions& options) {
  for (const Scenario& scenario : kScenarios) {
    if (scenario.name == scene) return MakeScenario(scenario, options);
  }
  for (const SuiteMember& member : kSuite) {
    if (member.name == scene) return MakeSuiteMember(member, options.object_count);
  }
  const std::filesystem::path path(std::u8string(scene.begin(), scene.end()));
  if (path.extension() == ".aabbs") return RecordedScene::Open(path);
  return UnknownScene(scene);
}

}  // namespace

std::span<const std::string_view> SceneNames() { return kNames; }

Result<std::unique_ptr<Scene>> MakeScene(std::string_view scene, const SceneOptions& options) {
  try {
    return MakeNamedScene(scene, options);
  } catch (const std::bad_alloc&) {
    return Status(StatusCode::kResourceExhausted,
                  "not enough memory for the scene: choose a smaller object_count or file");
  } catch (const std::system_error&) {
    return UnknownScene(scene);  // what is no UTF-8 names no file on Windows
  }
}

}  // namespace sweepstake
