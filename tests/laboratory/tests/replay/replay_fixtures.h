// Traces for the tests of replay, and scenes made of them.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "tests/laboratory/replay/replay_scene.h"
#include "tests/laboratory/tests/trace/synthetic_trace.h"

namespace sweepstake::cli {

inline ReplayScene SceneOf(const SyntheticTrace& trace, const GameOptions& options = {}) {
  auto scene = ReplayScene::Create(MakeTrace(trace), options);
  EXPECT_TRUE(scene.ok()) << scene.status().message();
  return std::move(*scene);
}

// Returns a trace in which KDTree takes twice as long as AxisSweep, which `thresholds` prefers. The
// first frame of a new structure takes four times as long as a frame of a running one. The five
// frames after the warm-up take a tenth longer.
inline SyntheticTrace TwiceAsSlow() {
  SyntheticTrace trace;
  trace.arms = {"AxisSweep", "KDTree"};
  trace.detection_ns = [](uint32_t, uint32_t arm) { return arm == 0 ? 50'000 : 100'000; };
  trace.slowdown = [](uint32_t k) {
    if (k == 0) return 4.0;
    return k < 3 ? 1.0 : 1.1;
  };
  return trace;
}

}  // namespace sweepstake::cli
