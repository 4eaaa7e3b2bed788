#include "tests/laboratory/io/time_left.h"

#include <chrono>
#include <cmath>

namespace sweepstake::cli {

std::string DurationText(double seconds) {
  const auto whole = [](double value) { return std::to_string(std::lround(value)); };
  if (seconds < 90) return whole(seconds) + " s";
  const double minutes = std::round(seconds / 60);
  if (minutes < 90) return whole(minutes) + " min";
  return whole(std::floor(minutes / 60)) + " h " + whole(std::fmod(minutes, 60)) + " min";
}

std::function<void(double share, const std::string& text)> OnShareWithTimeLeft(Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  return [&progress, start](double share, const std::string& text) {
    if (!progress.due() || share <= 0) return;
    const std::chrono::duration<double> used = std::chrono::steady_clock::now() - start;
    progress.OnShare()(share,
                       text + ", " + DurationText(used.count() / share * (1 - share)) + " left");
  };
}

}  // namespace sweepstake::cli
