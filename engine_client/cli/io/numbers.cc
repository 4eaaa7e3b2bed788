#include "engine_client/cli/io/numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace sweepstake::cli::html {
namespace {

constexpr const char* kNone = "–";

std::string WithDecimals(double value, int decimals) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

// "2.50" → "2.5", "10" stays.
std::string WithoutTrailingZeros(std::string text) {
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// How often `value` can be divided by 1000 and stay at least 1 when it is rounded; at most `max`.
int ThousandsIn(double value, int max) {
  int steps = 0;
  while (steps < max && std::abs(value) >= 999.5) {
    value /= 1000;
    ++steps;
  }
  return steps;
}

}  // namespace

std::string Significant(double value, int digits) {
  if (!std::isfinite(value)) return kNone;
  if (value == 0) return "0";
  // The value is rounded first, because 9.996 becomes 10.0 with three digits.
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - digits + 1);
  const double rounded = std::round(value / unit) * unit;
  const int first = static_cast<int>(std::floor(std::log10(std::abs(rounded)) + 1e-9));
  return WithDecimals(rounded, std::clamp(digits - 1 - first, 0, 300));
}

std::string Grouped(uint64_t value) {
  std::string text = std::to_string(value);
  for (size_t end = text.size(); end > 3; end -= 3) text.insert(end - 3, ",");
  return text;
}

std::string GroupedWhole(double value) {
  return Grouped(static_cast<uint64_t>(std::llround(value)));
}

std::string Compact(double value) {
  if (!std::isfinite(value)) return kNone;
  constexpr std::array<const char*, 4> kUnits{"", "k", "M", "G"};
  const int steps = ThousandsIn(value, 3);
  return WithoutTrailingZeros(Significant(value / std::pow(1000, steps), 3)) +
         kUnits[static_cast<size_t>(steps)];
}

std::string Bytes(double bytes) {
  if (!std::isfinite(bytes)) return kNone;
  constexpr std::array<const char*, 5> kUnits{" B", " kB", " MB", " GB", " TB"};
  const int steps = ThousandsIn(bytes, 4);
  if (steps == 0) return WithDecimals(bytes, 0) + kUnits[0];
  return Significant(bytes / std::pow(1000, steps), 3) + kUnits[static_cast<size_t>(steps)];
}

size_t LetterCount(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

}  // namespace sweepstake::cli::html
