#include <algorithm>
#include <cmath>
#include <span>

#include "engine_client/cli/trace/costs_file.h"

namespace sweepstake::cli {
namespace {

std::string FlawOfArms(const std::vector<TracedArm>& arms) {
  if (arms.empty() || arms.size() > kMostTracedArms) {
    return "has " + std::to_string(arms.size()) + " arms, not 1 to " +
           std::to_string(kMostTracedArms);
  }
  for (size_t i = 0; i < arms.size(); ++i) {
    const std::string& name = arms[i].name;
    constexpr size_t kMostLetters = 64;
    const bool printable =
        std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
    if (name.empty() || name.size() > kMostLetters || !printable)
      return "has an arm without a name";
    for (size_t j = 0; j < i; ++j) {
      if (arms[j].name == name) return "has the arm " + name + " twice";
    }
  }
  return "";
}

bool IsOneShortLine(const std::string& text) {
  constexpr size_t kMostBytes = 1000;
  return text.size() <= kMostBytes && std::none_of(text.begin(), text.end(), [](unsigned char c) {
           return c < ' ' || c == 0x7F;
         });
}

std::string FlawOfCounts(const CostTrace& trace) {
  if (trace.frame_count == 0 || trace.frame_count > kMostTracedFrames) {
    return "has " + std::to_string(trace.frame_count) + " frames, not 1 to " +
           std::to_string(kMostTracedFrames);
  }
  if (!IsOneShortLine(trace.scene) || !IsOneShortLine(trace.machine)) {
    return "has a scene or machine whose name is no short line";
  }
  if (trace.repeat_count == 0) return "was measured no time";
  if (trace.control_arm >= trace.arms.size()) return "has no such control arm as it says";
  if (trace.burst_frame_count < 2 || trace.burst_frame_count > kMostBurstFrames) {
    return "has bursts of " + std::to_string(trace.burst_frame_count) + " frames, not 2 to " +
           std::to_string(kMostBurstFrames);
  }
  return "";
}

std::string FlawOfTimes(const std::string& column, std::span<const uint64_t> times, size_t count) {
  if (times.size() != count) return "has a column " + column + " of another length than its frames";
  const bool sound = std::all_of(times.begin(), times.end(),
                                 [](uint64_t ns) { return ns >= 1 && ns <= kMostTracedNs; });
  return sound ? "" : "has a time of nothing or of more than an hour in its column " + column;
}

std::string FlawOfColumns(const CostTrace& trace) {
  const size_t frames = trace.frame_count;
  const size_t all = frames * trace.arms.size();
  const std::pair<const char*, bool> lengths[] = {
      {"object_count", trace.object_count.size() == frames},
      {"pair_count", trace.pair_count.size() == frames},
      {"step_ns", trace.step_ns.size() == frames},
      {"aabb_check_count", trace.aabb_check_count.size() == all},
      {"native_bytes", trace.native_bytes.size() == all},
      {"held", trace.held.size() == all},
  };
  for (const auto& [column, fits] : lengths) {
    if (!fits) return std::string("has a column ") + column + " of another length than its frames";
  }
  if (std::any_of(trace.held.begin(), trace.held.end(), [](uint8_t held) { return held > 1; })) {
    return "has a column held with other values than 0 and 1";
  }
  if (std::string flaw = FlawOfTimes("control_ns", trace.control_ns, frames); !flaw.empty()) {
    return flaw;
  }
  return FlawOfTimes("detection_ns", trace.detection_ns, all);
}

std::string FlawOfBursts(const CostTrace& trace) {
  if (trace.bursts.empty()) return "has no burst";
  const uint32_t length = trace.burst_frame_count;
  uint64_t free_from = 0;
  for (const TraceBurst& burst : trace.bursts) {
    if (burst.first_frame < free_from || burst.first_frame + uint64_t{length} > trace.frame_count) {
      return "has a burst out of order or out of its frames";
    }
    free_from = burst.first_frame + uint64_t{1};
    if (std::string flaw =
            FlawOfTimes("detection_ns of a burst", burst.detection_ns, length * trace.arms.size());
        !flaw.empty()) {
      return flaw;
    }
  }
  return "";
}

bool IsFinite(const SceneDescriptor& descriptor) {
  const float fields[] = {descriptor.object_count, descriptor.density_ratio,
                          descriptor.size_spread,  descriptor.speed_mean,
                          descriptor.speed_spread, descriptor.clustering_ratio,
                          descriptor.static_ratio};
  return std::all_of(std::begin(fields), std::end(fields),
                     [](float value) { return std::isfinite(value); });
}

std::string FlawOfDescriptors(const CostTrace& trace) {
  uint32_t last = 0;
  for (const TracedDescriptor& traced : trace.descriptors) {
    if (traced.frame < last || traced.frame > trace.frame_count || !IsFinite(traced.descriptor)) {
      return "has a descriptor out of order or with a number that is not finite";
    }
    last = traced.frame;
  }
  return "";
}

}  // namespace

std::string FlawOf(const CostTrace& trace) {
  for (const auto& flaw_of : {+[](const CostTrace& t) { return FlawOfArms(t.arms); }, FlawOfCounts,
                              FlawOfColumns, FlawOfBursts, FlawOfDescriptors}) {
    if (std::string flaw = flaw_of(trace); !flaw.empty()) return flaw;
  }
  return "";
}

}  // namespace sweepstake::cli
