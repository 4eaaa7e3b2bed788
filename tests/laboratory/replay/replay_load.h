// Other work on the core of a replayed game's frame thread, such as another process or memory
// traffic of a neighbour. It starts and stops at random and lengthens all frames in between. The
// shadow lane runs on another core and is not affected.
//
// Deterministic; not thread-safe. Times are nanoseconds of virtual time.
#pragma once

#include <cstdint>

namespace sweepstake::cli {

struct FrameLoad {
  double ratio = 1;    // time of a frame meanwhile ÷ without; >= 1
  double share = 0.1;  // of the time; 0 < share < 1
};

class ReplayLoad {
 public:
  ReplayLoad(const FrameLoad& load, uint64_t seed) : load_(load), seed_(seed) {}

  // Returns the ratio of a frame that begins now. REQUIRES: now_ns >= that of the last call.
  double RatioAt(int64_t now_ns);

 private:
  FrameLoad load_;
  uint64_t seed_;
  // Number of the current stretch. Stretches without and with the work alternate; the first is
  // without.
  uint64_t stretch_count_ = 0;
  int64_t stretch_end_ns_ = 0;
};

}  // namespace sweepstake::cli
