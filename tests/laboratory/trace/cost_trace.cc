#include "tests/laboratory/trace/cost_trace.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "tests/laboratory/io/document_file.h"

namespace sweepstake {

// Defines the JSON conversions, in the namespace of the structs because the JSON library searches
// there. The names of the fields are also their names in the file.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SceneDescriptor, object_count, density_ratio, size_spread,
                                   speed_mean, speed_spread, clustering_ratio, static_ratio)

namespace cli {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TracedArm, name, version)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TraceBurst, first_frame, detection_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TracedDescriptor, frame, descriptor)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CostTrace, scene, seed, machine, arms, frame_count, repeat_count,
                                   object_count, pair_count, step_ns, control_ns, detection_ns,
                                   aabb_check_count, native_bytes, held, control_arm,
                                   burst_frame_count, bursts, descriptors)

namespace {

constexpr DocumentFormat kFormat{.name = "sweepstake-costs",
                                 .version = 2,
                                 .kind = "cost trace",
                                 .remedy = "; `sweepstake-lab trace` makes .costs files",
                                 .is_cbor = true};

bool IsLine(const std::string& text, size_t max_bytes) {
  return text.size() <= max_bytes && std::none_of(text.begin(), text.end(), [](unsigned char c) {
           return c < ' ' || c == 0x7F;
         });
}

bool HasValidArms(const std::vector<TracedArm>& arms) {
  constexpr size_t kMaxArms = 64;
  std::set<std::string> names;
  for (const TracedArm& arm : arms) {
    if (arm.name.empty() || !IsLine(arm.name, 64) || !names.insert(arm.name).second) return false;
  }
  return !arms.empty() && arms.size() <= kMaxArms;
}

bool AreTimes(std::span<const uint64_t> column, size_t count) {
  return column.size() == count && std::all_of(column.begin(), column.end(), [](uint64_t ns) {
           return ns >= 1 && ns <= kMaxTracedNs;
         });
}

bool HasValidBursts(const CostTrace& trace) {
  uint64_t free_from = 0;
  for (const TraceBurst& burst : trace.bursts) {
    const uint64_t end = burst.first_frame + uint64_t{trace.burst_frame_count};
    if (burst.first_frame < free_from || end > trace.frame_count ||
        !AreTimes(burst.detection_ns, trace.burst_frame_count * trace.arms.size())) {
      return false;
    }
    free_from = burst.first_frame + uint64_t{1};
  }
  return !trace.bursts.empty();
}

bool HasValidDescriptors(const CostTrace& trace) {
  uint32_t last = 0;
  for (const auto& [frame, of_scene] : trace.descriptors) {
    const float sum = of_scene.object_count + of_scene.density_ratio + of_scene.size_spread +
                      of_scene.speed_mean + of_scene.speed_spread + of_scene.clustering_ratio +
                      of_scene.static_ratio;
    if (frame < last || frame > trace.frame_count || !std::isfinite(sum)) return false;
    last = frame;
  }
  return true;
}

}  // namespace

std::string ErrorOf(const CostTrace& trace) {
  constexpr size_t kMaxName = 1000;
  const size_t frames = trace.frame_count;
  const size_t all = frames * trace.arms.size();
  const uint32_t burst = trace.burst_frame_count;
  const bool is_held_a_flag =
      std::all_of(trace.held.begin(), trace.held.end(), [](uint8_t held) { return held <= 1; });
  const std::pair<bool, const char*> rules[] = {
      {HasValidArms(trace.arms), "it does not have 1 to 64 arms with different names"},
      {frames >= 1 && frames <= kMaxTracedFrames, "frame_count is out of range"},
      {IsLine(trace.scene, kMaxName), "scene is not one short line"},
      {IsLine(trace.machine, kMaxName), "machine is not one short line"},
      {trace.repeat_count > 0, "repeat_count is 0"},
      {trace.control_arm < trace.arms.size(), "control_arm is out of range"},
      {burst >= 2 && burst <= kMaxBurstFrames, "burst_frame_count is out of range"},
      {trace.object_count.size() == frames, "object_count has the wrong length"},
      {trace.pair_count.size() == frames, "pair_count has the wrong length"},
      {trace.step_ns.size() == frames, "step_ns has the wrong length"},
      {trace.aabb_check_count.size() == all, "aabb_check_count has the wrong length"},
      {trace.native_bytes.size() == all, "native_bytes has the wrong length"},
      {trace.held.size() == all && is_held_a_flag, "held is not a list of 0 and 1 per frame"},
      {AreTimes(trace.control_ns, frames), "control_ns is not a list of times"},
      {AreTimes(trace.detection_ns, all), "detection_ns is not a list of times"},
      {HasValidBursts(trace), "a burst is missing, out of order or not a list of times"},
      {HasValidDescriptors(trace), "a descriptor is out of order or not finite"},
  };
  for (const auto& [holds, error] : rules) {
    if (!holds) return error;
  }
  return "";
}

Status WriteCosts(const std::filesystem::path& path, const CostTrace& trace) {
  return WriteDocument(path, kFormat, {{"trace", nlohmann::json(trace)}});
}

Result<CostTrace> ReadCosts(const std::filesystem::path& path) {
  CostTrace trace;
  Status status = ReadDocument(path, kFormat, [&](const nlohmann::json& document) {
    document.at("trace").get_to(trace);
    return ErrorOf(trace);
  });
  if (!status.ok()) return status;
  return trace;
}

}  // namespace cli
}  // namespace sweepstake
