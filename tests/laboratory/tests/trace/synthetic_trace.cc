#include "tests/laboratory/tests/trace/synthetic_trace.h"

namespace sweepstake::cli {

CostTrace MakeTrace(const SyntheticTrace& synthetic) {
  CostTrace trace;
  trace.scene = "synthetic";
  trace.machine = "none";
  for (const std::string& arm : synthetic.arms) trace.arms.push_back({.name = arm, .version = 1});
  const uint32_t arms = trace.arm_count();
  trace.frame_count = synthetic.frame_count;
  trace.burst_frame_count = synthetic.burst_frame_count;
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    trace.object_count.push_back(1000);
    trace.pair_count.push_back(10);
    trace.step_ns.push_back(1);
    trace.control_ns.push_back(synthetic.detection_ns(frame, 0));
    for (uint32_t arm = 0; arm < arms; ++arm) {
      trace.detection_ns.push_back(synthetic.detection_ns(frame, arm));
      trace.aabb_check_count.push_back(2000);
      trace.native_bytes.push_back(4096);
      trace.held.push_back(0);
    }
  }
  for (uint32_t first = 0; first + trace.burst_frame_count <= trace.frame_count;
       first += synthetic.burst_interval) {
    TraceBurst burst;
    burst.first_frame = first;
    for (uint32_t arm = 0; arm < arms; ++arm) {
      for (uint32_t k = 0; k < trace.burst_frame_count; ++k) {
        const auto ns = static_cast<double>(synthetic.detection_ns(first, arm));
        burst.detection_ns.push_back(static_cast<uint64_t>(ns * synthetic.slowdown(k)));
      }
    }
    trace.bursts.push_back(burst);
  }
  SceneDescriptor descriptor;
  descriptor.object_count = 1000;
  trace.descriptors.push_back({.frame = 0, .descriptor = descriptor});
  return trace;
}

}  // namespace sweepstake::cli
