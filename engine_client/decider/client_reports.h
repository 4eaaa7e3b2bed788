// The reports that a client sends to a decider, in addition to the structs of frame_sample.h, and
// limits of the protocol. telemetry.proto describes the fields.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sweepstake/frame_sample.h"

namespace sweepstake::protocol {

inline constexpr uint32_t kVersion = 1;  // daemons refuse clients with another version
inline constexpr uint32_t kMaxBatchFrames = 240;
inline constexpr uint32_t kMaxMessageBytes = 256 * 1024;  // a longer message is RESOURCE_EXHAUSTED
inline constexpr uint32_t kRecordsPerMessage = 200;       // of evidence, in an import or an export

// Consecutive frames. Their index and pair count are not sent.
struct FrameBatch {
  std::vector<FrameSample> frames;
  std::optional<SceneDescriptor> scene_descriptor;  // only its values >= 0 are sent
  uint64_t dropped_frame_count = 0;
  std::vector<ShadowSample> shadow_samples;
  uint32_t invalid_box_count = 0;  // the largest of these frames

  uint64_t first_frame_index() const { return frames.empty() ? 0 : frames.front().frame_index; }
};

// A frame over the bail-out limit.
struct BailOut {
  FrameSample frame;
};

// A received reason may have a value that only a newer protocol defines.
enum class OrderRefusalReason : uint32_t { kNotAllowed = 1, kUnknown = 2 };

struct OrderRefusal {
  uint64_t order_id = 0;
  OrderRefusalReason reason = OrderRefusalReason::kUnknown;
};

}  // namespace sweepstake::protocol
