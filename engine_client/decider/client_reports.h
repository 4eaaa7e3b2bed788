// Reports of a client to a decider over a connection, beside those of frame_sample.h.
// telemetry.proto describes their fields.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sweepstake/frame_sample.h"

namespace sweepstake::protocol {

// Consecutive frames. Their index and pair count are not sent.
struct FrameBatch {
  std::vector<FrameSample> frames;
  std::optional<SceneDescriptor> scene_descriptor;  // only its values >= 0 are sent
  uint64_t dropped_frame_count = 0;
  std::vector<ShadowSample> shadow_samples;
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
