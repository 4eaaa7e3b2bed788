#include "engine_client/scene/degenerate_scenes.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "engine_client/scene/box_scenes.h"

namespace sweepstake {
namespace {

constexpr uint32_t kMaxObjects = 100'000;
constexpr std::string_view kCountChanging = "count-changing";

// A family besides the kinds: which kind it shows, and how many objects where that is fixed.
struct Special {
  std::string_view name;
  std::string_view kind;
  uint32_t object_count;
};
constexpr uint32_t kAnyCount = std::numeric_limits<uint32_t>::max();
constexpr Special kSpecials[] = {
    {"empty", "brownian", 0},
    {"one", "brownian", 1},
    {"two", "touching-faces", 2},
    {kCountChanging, "mixture", kAnyCount},
};

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
  names.insert(names.end(), BoxSceneKinds().begin(), BoxSceneKinds().end());
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
  if (object_count > kMaxObjects) {
    return Status(StatusCode::kInvalidArgument, "a degenerate scene holds at most 100000 objects");
  }
  std::string_view kind = name;
  for (const Special& special : kSpecials) {
    if (special.name != name) continue;
    kind = special.kind;
    if (special.object_count != kAnyCount) object_count = special.object_count;
  }
  return std::unique_ptr<Scene>(
      std::make_unique<DegenerateScene>(*known, kind, object_count, seed));
}

}  // namespace sweepstake
