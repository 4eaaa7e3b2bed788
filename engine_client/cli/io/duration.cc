#include "engine_client/cli/io/duration.h"

#include <charconv>
#include <ctime>

namespace sweepstake::cli {
namespace {

constexpr double kMaxNs = 30.0 * 24 * 3600 * 1e9;

// Returns the number of nanoseconds in a unit, or 0 for an unknown unit.
double UnitNs(std::string_view unit) {
  if (unit == "ms") return 1e6;
  if (unit == "s") return 1e9;
  if (unit == "m") return 60e9;
  return unit == "h" ? 3600e9 : 0;
}

}  // namespace

Result<uint64_t> ParseDuration(std::string_view text, uint64_t min_ns) {
  double number = 0;
  const auto [rest, error] =
      std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  const double unit_ns = UnitNs({rest, static_cast<size_t>(text.data() + text.size() - rest)});
  const double total_ns = number * unit_ns;
  // The condition is written with "!", so that it also rejects NaN.
  if (error != std::errc() || unit_ns == 0 ||
      !(total_ns >= static_cast<double>(min_ns) && total_ns <= kMaxNs)) {
    return Status(StatusCode::kInvalidArgument, "'" + std::string(text) +
                                                    "' is not a duration: give a number and ms, s, "
                                                    "m or h, such as 500ms, 60s or 15m, of at "
                                                    "most 720h");
  }
  return static_cast<uint64_t>(total_ns);
}

std::string UtcText(int64_t unix_ms) {
  const std::time_t seconds = unix_ms / 1000;
  std::tm parts{};
  char text[32];
  if (gmtime_r(&seconds, &parts) == nullptr) return "";
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts)};
}

}  // namespace sweepstake::cli
