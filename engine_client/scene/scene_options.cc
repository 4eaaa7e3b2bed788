#include "engine_client/scene/scene_options.h"

#include <locale>
#include <sstream>

namespace sweepstake {
namespace {

struct RangedOption {
  const char* name;
  float value;
  float lowest;
  float highest;
};

template <typename T>
Status OutOfRange(const char* name, T lowest, T highest, T value) {
  std::ostringstream message;
  message.imbue(std::locale::classic());
  message << name << " must be from " << lowest << " to " << highest << ", not " << value;
  return {StatusCode::kInvalidArgument, message.str()};
}

}  // namespace

Status ValidateObjectCount(uint32_t object_count) {
  if (object_count <= kMaxSceneObjectCount) return {};
  return OutOfRange<uint32_t>("object_count", 0, kMaxSceneObjectCount, object_count);
}

Status ValidateSceneOptions(const SceneOptions& options) {
  if (Status status = ValidateObjectCount(options.object_count); !status.ok()) return status;
  const RangedOption ranged[] = {
      {"world_half_extent", options.world_half_extent, 1e-3F, 1e6F},
      {"fixed_step_s", options.fixed_step_s, 1e-6F, 1},
      {"half_extent_min", options.half_extent_min, 1e-6F, options.world_half_extent},
      {"half_extent_max", options.half_extent_max, options.half_extent_min,
       options.world_half_extent},
      {"speed", options.speed, 0, 1e6F},
      {"gravity", options.gravity, 0, 1e6F},
      {"direction_interval_s", options.direction_interval_s, 1e-6F, 1e6F},
  };
  for (const RangedOption& option : ranged) {
    const bool in_range = option.value >= option.lowest && option.value <= option.highest;
    if (!in_range) return OutOfRange(option.name, option.lowest, option.highest, option.value);
  }
  return {};
}

}  // namespace sweepstake
