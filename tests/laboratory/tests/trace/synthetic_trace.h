// Cost traces with numbers that the test chooses.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

struct SyntheticTrace {
  std::vector<std::string> arms = {"A", "B"};
  uint32_t frame_count = 64;
  // The time of `arm` in frame `frame`.
  std::function<uint64_t(uint32_t frame, uint32_t arm)> detection_ns;
  // The time of a fresh structure's frame k ÷ the time of a running structure.
  std::function<double(uint32_t k)> slowdown = [](uint32_t) { return 1.0; };
  uint32_t burst_frame_count = 8;
  uint32_t burst_interval = 16;
};

CostTrace MakeTrace(const SyntheticTrace& trace);

}  // namespace sweepstake::cli
