// A view of boxes in groups of sixteen: six runs of floats and one of ids each, wherever they are.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/soa_boxes.h"

namespace sweepstake {

// Of the first group; those of the next are `stride` further on. The last group is filled up with
// sentinels (soa_boxes.h).
struct BoxGroups {
  static constexpr size_t kWidth = 16;

  const float* min[3];
  const float* max[3];
  const uint32_t* id;
  size_t stride;
  size_t count;  // of groups
};

inline BoxGroups GroupsOf(const BoxLanes& lanes) {
  return {{lanes.min[0], lanes.min[1], lanes.min[2]},
          {lanes.max[0], lanes.max[1], lanes.max[2]},
          lanes.id,
          BoxGroups::kWidth,
          (lanes.count + BoxGroups::kWidth - 1) / BoxGroups::kWidth};
}

}  // namespace sweepstake
