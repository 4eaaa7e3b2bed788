// Formats numbers for people. Pure functions, safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::cli {

// Returns the number with commas between thousands: "12,345,678".
std::string Grouped(uint64_t value);
// Returns the nearest whole number with commas. REQUIRES: 0 <= value < 2^63.
std::string GroupedWhole(double value);

// Returns the number of characters of UTF-8 text.
size_t LetterCount(std::string_view text);

}  // namespace sweepstake::cli
