#include "engine_client/scene/degenerate_scenes.h"

#include <algorithm>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/scene_options.h"

namespace sweepstake {
namespace {

constexpr std::string_view kScenario = "brownian";  // the kind whose name a scenario has
constexpr std::string_view kCountChanging = "count-changing";
constexpr std::string_view kSpawning = "spawning";

// A family besides the kinds: which kind it shows, and how many objects where that is fixed.
struct Special {
  std::string_view name;
  std::string_view kind;
  uint32_t object_count;
};
constexpr uint32_t kAnyCount = std::numeric_limits<uint32_t>::max();
constexpr Special kSpecials[] = {
    {"empty", "brownian", 0},           {"one", "brownian", 1},
    {"two", "touching-faces", 2},       {kCountChanging, "mixture", kAnyCount},
    {kSpawning, "brownian", kAnyCount},
};

// Up to `most` and down to its half, a 64th at a time.
size_t SpawnedCount(size_t most, uint64_t frame) {
  const uint64_t phase = frame % 64;
  return most - most * (phase < 32 ? phase : 64 - phase) / 64;
}

class DegenerateScene : public Scene {
 public:
  DegenerateScene(std::string_view name, std::string_view kind, uint32_t object_count,
                  uint64_t seed)
      : name_(name), boxes_(kind, object_count, seed), counts_(seed), shown_(object_count) {}

  std::string_view name() const override { return name_; }
  Aabb world() const override { return {{-50, -50, -50}, {50, 50, 50}}; }
  uint64_t frame_index() const override { return frame_index_; }
  std::span<const Aabb> aabbs() const override { return boxes_.boxes().first(shown_); }
  void Step() override {
    ++frame_index_;
    boxes_.Step();
    if (name_ == kSpawning) shown_ = SpawnedCount(boxes_.boxes().size(), frame_index_);
    if (name_ == kCountChanging) {
      shown_ = frame_index_ % 7 == 3 ? 0 : counts_.Below(boxes_.boxes().size() + 1);
    }
  }

 private:
  std::string_view name_;
  BoxScene boxes_;
  SequentialRandom counts_;
  size_t shown_;
  uint64_t frame_index_ = 0;
};

std::vector<std::string_view> MakeNames() {
  std::vector<std::string_view> names;
  for (const Special& special : kSpecials) names.push_back(special.name);
  for (const std::string_view kind : BoxSceneKinds()) {
    if (kind != kScenario) names.push_back(kind);
  }
  return names;
}

Status UnknownName(std::string_view name) {
  std::string message = "no degenerate scene is called '" + std::string(name) + "'; choose one of ";
  for (const std::string_view each : DegenerateSceneNames()) {
    if (each != DegenerateSceneNames().front()) message += ", ";
    message += each;
  }
  return {StatusCode::kNotFound, std::move(message)};
}

}  // namespace

std::span<const std::string_view> DegenerateSceneNames() {
  static const std::vector<std::string_view> names = MakeNames();
  return names;
}

Result<std::unique_ptr<Scene>> MakeDegenerateScene(std::string_view name, uint32_t object_count,
                                                   uint64_t seed) {
  const auto names = DegenerateSceneNames();
  const auto known = std::find(names.begin(), names.end(), name);
  if (known == names.end()) return UnknownName(name);
  if (Status status = ValidateObjectCount(object_count); !status.ok()) return status;
  std::string_view kind = name;
  for (const Special& special : kSpecials) {
    if (special.name != name) continue;
    kind = special.kind;
    if (special.object_count != kAnyCount) object_count = special.object_count;
  }
  try {
    return std::unique_ptr<Scene>(
        std::make_unique<DegenerateScene>(*known, kind, object_count, seed));
  } catch (const std::bad_alloc&) {
    return Status(StatusCode::kResourceExhausted,
                  "not enough memory for the scene: choose a smaller object_count");
  }
}

}  // namespace sweepstake
