#include "engine_client/cli/scene_timing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace sweepstake::cli {
namespace {

using std::chrono::steady_clock;

// One frame; the time it took in milliseconds.
double TimeFrame(BroadPhase& arm, std::span<const Aabb> boxes, PairBuffer& pairs) {
  pairs.Clear();
  const auto start = steady_clock::now();
  arm.Update(boxes);
  arm.FindPairs(pairs);
  return std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
}

void Summarize(std::vector<double> times, ArmTiming& timing) {
  std::sort(times.begin(), times.end());
  timing.ms_median = Median(times);
  timing.ms_mean =
      std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
  timing.ms_min = times.front();
  timing.ms_p99 = Quantile(times, 0.99);
}

}  // namespace

ArmTiming TimeScene(Scene& scene, BroadPhase& arm, uint64_t warmup, uint64_t frames,
                    const std::function<void(uint64_t)>& on_frame) {
  PairBuffer pairs;
  ArmTiming timing;
  std::vector<double> times;
  times.reserve(frames);
  arm.Build(scene.aabbs());
  arm.FindPairs(pairs);
  for (uint64_t step = 1; step <= warmup + frames; ++step) {
    scene.Step();
    const double time_ms = TimeFrame(arm, scene.aabbs(), pairs);
    on_frame(step);
    if (step <= warmup) continue;
    times.push_back(time_ms);
    timing.pairs_mean += static_cast<double>(pairs.size());
    timing.aabb_checks_mean += static_cast<double>(arm.aabb_check_count());
    timing.bytes = std::max<uint64_t>(timing.bytes, arm.native_bytes());
  }
  timing.frame_count = frames;
  timing.pairs_mean /= static_cast<double>(frames);
  timing.aabb_checks_mean /= static_cast<double>(frames);
  Summarize(std::move(times), timing);
  return timing;
}

double Quantile(const std::vector<double>& sorted, double ratio) {
  const auto rank = static_cast<size_t>(std::ceil(ratio * static_cast<double>(sorted.size())));
  return sorted[std::clamp<size_t>(rank, 1, sorted.size()) - 1];
}

double Median(const std::vector<double>& sorted) {
  const size_t middle = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

}  // namespace sweepstake::cli
