#include "tests/laboratory/replay/replay_load.h"

#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"

namespace sweepstake::cli {
namespace {

constexpr double kMeanBusyNs = 10e9;  // of a stretch, whose length is exponentially distributed

}  // namespace

double ReplayLoad::RatioAt(int64_t now_ns) {
  if (load_.ratio == 1) return 1;
  while (now_ns >= stretch_end_ns_) {
    ++stretch_count_;
    decision::RandomStream random(seed_, decision::RandomPurpose::kReplayLoad, stretch_count_, 0);
    const double mean_ns =
        stretch_count_ % 2 == 0 ? kMeanBusyNs : kMeanBusyNs * (1 - load_.share) / load_.share;
    stretch_end_ns_ += static_cast<int64_t>(-mean_ns * math::Log(random.NextUniform())) + 1;
  }
  return stretch_count_ % 2 == 0 ? load_.ratio : 1;
}

}  // namespace sweepstake::cli
