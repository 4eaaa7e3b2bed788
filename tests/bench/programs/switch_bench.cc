// Measures the cost of switching arms for the frame that switches, without the shadow lane (cold)
// and with it (warm), for all ordered pairs of arms, and the cost of the lane for every other
// frame.
//
//   switch_bench [OBJECTS,…] [REPEATS] [ARM,…]
//
// A switch is: some frames on one arm, a command for the other, frames until it is executed, and
// then enough frames for a median. The figure is the detection time of the switching frame ÷ the
// median of the new arm's later frames, as the median over the repeats. Each repeat starts with new
// backends, so that a cold switch goes to an arm that was never active. Frames are not paced and
// only the broad phase runs, which is the worst case: in a game the rest of the frame evicts
// everything from the cache in every frame, not only in the switching frame.
//
// The lane's cost: blocks of frames alternate between a working lane (kAi) and a paused one
// (kManual). The figure is the ratio of the mean frame times of neighbouring blocks; the control is
// the ratio of two paused blocks.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

constexpr int kFramesBefore = 12;
constexpr int kFramesAfter = 24;
constexpr int kFramesUnsettled = 4;  // first frames after a switch, excluded from the median
constexpr int kBlocks = 12;
constexpr uint64_t kBlockNs = 150'000'000;

std::vector<std::string> Split(const std::string& list) {
  std::vector<std::string> items;
  std::stringstream stream(list);
  for (std::string item; std::getline(stream, item, ',');) items.push_back(item);
  return items;
}

// Returns the median, and for an even number of values the upper of the two in the middle.
double UpperMedian(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

struct FrameTimes {
  double frame = 0;
  double detection = 0;
};

// The frame path and its scene.
class Game {
 public:
  Game(const AdaptiveOptions& options, uint32_t object_count)
      : scene_(std::move(*MakeScene("suite-b", {.object_count = object_count}))),
        adaptive_(std::move(*AdaptiveBroadPhase::Create(options, nullptr))) {}

  FrameTimes Frame() {
    const uint64_t begin_ns = SteadyClock().NowNs();
    scene_->Step();
    adaptive_->BeginFrame();
    adaptive_->FindPairs(scene_->aabbs());
    adaptive_->EndFrame({.frame_time_ns = last_ns_});
    last_ns_ = SteadyClock().NowNs() - begin_ns;
    return {static_cast<double>(last_ns_),
            static_cast<double>(adaptive_->last_sample().detection_time_ns)};
  }

  AdaptiveBroadPhase& adaptive() { return *adaptive_; }

 private:
  uint64_t last_ns_ = 0;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

// Returns the switching frame's time ÷ the median of the frames after it.
FrameTimes SwitchRatio(const std::vector<std::string>& arms, uint32_t from, uint32_t to,
                       uint32_t object_count, ShadowMode lane) {
  Game game({.arms = arms, .initial_arm = arms[from], .shadow = {.enabled = lane}}, object_count);
  for (int frame = 0; frame < kFramesBefore; ++frame) game.Frame();
  game.adaptive().mailbox().Post({.command_id = 1, .arm = to});
  FrameTimes switching;
  while (game.adaptive().active_arm() != to) switching = game.Frame();
  std::vector<double> frames;
  std::vector<double> detections;
  for (int frame = 0; frame < kFramesAfter; ++frame) {
    const FrameTimes times = game.Frame();
    if (frame < kFramesUnsettled) continue;
    frames.push_back(times.frame);
    detections.push_back(times.detection);
  }
  return {switching.frame / UpperMedian(frames), switching.detection / UpperMedian(detections)};
}

void PrintSummary(const char* what, const std::vector<double>& ratios) {
  const auto over = std::count_if(ratios.begin(), ratios.end(), [](double r) { return r > 1.2; });
  std::printf("%s: median %.2f, largest %.2f, over 1.2: %d of %zu\n", what, UpperMedian(ratios),
              *std::max_element(ratios.begin(), ratios.end()), static_cast<int>(over),
              ratios.size());
}

void PrintMatrix(const std::vector<std::string>& arms, const std::vector<double>& ratios) {
  std::printf("%-11s", "from \\ to");
  for (const std::string& arm : arms) std::printf("%11s", arm.c_str());
  for (size_t from = 0; from < arms.size(); ++from) {
    std::printf("\n%-11s", arms[from].c_str());
    for (size_t to = 0; to < arms.size(); ++to) {
      if (from == to) {
        std::printf("%11s", "");
      } else {
        std::printf("%11.2f", ratios[from * arms.size() + to]);
      }
    }
  }
  std::printf("\n");
}

void MeasureSwitches(const std::vector<std::string>& arms, uint32_t object_count, int repeats,
                     ShadowMode lane) {
  const auto arm_count = static_cast<uint32_t>(arms.size());
  std::vector<double> matrix(arms.size() * arms.size());
  std::vector<double> frame_ratios;
  std::vector<double> detection_ratios;
  for (uint32_t pair = 0; pair < arm_count * arm_count; ++pair) {
    const uint32_t from = pair / arm_count;
    const uint32_t to = pair % arm_count;
    if (from == to) continue;
    std::vector<double> frames;
    std::vector<double> detections;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      const FrameTimes ratio = SwitchRatio(arms, from, to, object_count, lane);
      frames.push_back(ratio.frame);
      detections.push_back(ratio.detection);
    }
    frame_ratios.push_back(matrix[pair] = UpperMedian(frames));
    detection_ratios.push_back(UpperMedian(detections));
  }
  std::printf("\n%s switches, %u objects: switching frame / median frame of the new arm\n",
              lane == ShadowMode::kOff ? "cold" : "warm", object_count);
  PrintMatrix(arms, matrix);
  PrintSummary("frames", frame_ratios);
  PrintSummary("detection alone", detection_ratios);
}

// Returns the mean frame time of a block without its first fifth, because a sweep may extend into
// it.
double BlockMean(Game& game, Mode mode) {
  game.adaptive().SetMode(mode);
  double sum = 0;
  int count = 0;
  const uint64_t begin_ns = SteadyClock().NowNs();
  for (uint64_t now_ns = begin_ns; now_ns < begin_ns + kBlockNs;) {
    const double time = game.Frame().frame;
    now_ns = SteadyClock().NowNs();
    if (now_ns < begin_ns + kBlockNs / 5) continue;
    sum += time;
    ++count;
  }
  return sum / count;
}

void PrintRatio(const char* what, const std::vector<double>& ratios) {
  double sum = 0;
  double square_sum = 0;
  for (const double ratio : ratios) {
    sum += ratio;
    square_sum += ratio * ratio;
  }
  const double count = static_cast<double>(ratios.size());
  const double mean = sum / count;
  const double error = std::sqrt(std::max(square_sum / count - mean * mean, 0.0) / (count - 1));
  std::printf("%-28s %.3f ± %.3f (median %.3f)\n", what, mean, 2 * error, UpperMedian(ratios));
}

void MeasureLane(const std::vector<std::string>& arms, uint32_t object_count) {
  Game game({.arms = arms, .initial_arm = arms[1]}, object_count);
  std::vector<double> on_to_off;
  std::vector<double> off_to_off;
  BlockMean(game, Mode::kAi);  // Completes the first sweep, which no budget delays.
  for (int block = 0; block < kBlocks; ++block) {
    const double off = BlockMean(game, Mode::kManual);
    const double on = BlockMean(game, Mode::kAi);
    const double off_again = BlockMean(game, Mode::kManual);
    const double control = BlockMean(game, Mode::kManual);
    on_to_off.push_back(2 * on / (off + off_again));
    off_to_off.push_back(control / off_again);
  }
  const ShadowStats stats = game.adaptive().shadow_stats();
  std::printf("\nlane, %u objects, %s active: %llu sweeps, %llu frames copied at %.1f us\n",
              object_count, arms[1].c_str(), static_cast<unsigned long long>(stats.sweep_count),
              static_cast<unsigned long long>(stats.copied_frame_count),
              static_cast<double>(stats.copy_time_ns) /
                  static_cast<double>(std::max<uint64_t>(stats.copied_frame_count, 1)) / 1000);
  PrintRatio("frame time, on / off", on_to_off);
  PrintRatio("control, off / off", off_to_off);
}

int Main(const std::vector<std::string>& arguments) {
  const std::vector<std::string> sizes = Split(arguments.empty() ? "1000,10000" : arguments[0]);
  const int repeats = arguments.size() < 2 ? 5 : std::atoi(arguments[1].c_str());
  std::vector<std::string> arms(BroadPhaseNames().begin(), BroadPhaseNames().end());
  if (arguments.size() > 2) arms = Split(arguments[2]);
  for (const std::string& size : sizes) {
    const auto object_count = static_cast<uint32_t>(std::atoi(size.c_str()));
    if (repeats > 0) {
      MeasureSwitches(arms, object_count, repeats, ShadowMode::kOff);
      MeasureSwitches(arms, object_count, repeats, ShadowMode::kOn);
    }
    MeasureLane(arms, object_count);
  }
  return 0;
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  return sweepstake::Main(std::vector<std::string>(argv + 1, argv + argc));
}
