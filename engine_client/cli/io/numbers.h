// Writes numbers for people. Pure functions, safe from any thread. A number that is not finite
// becomes "–".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::cli::html {

// With `digits` significant digits and without an exponent: 0.0345, 12.3, 1230.
// REQUIRES: 1 <= digits <= 9.
std::string Significant(double value, int digits = 3);

// With commas between thousands: "12,345,678".
std::string Grouped(uint64_t value);
// The nearest whole number, with commas. REQUIRES: 0 <= value < 2^63.
std::string GroupedWhole(double value);

// Short, for axes and narrow columns: "800", "1k", "2.5k", "100k", "1M".
std::string Compact(double value);

// In powers of 1000: "512 B", "11.2 kB", "3.40 MB".
std::string Bytes(double bytes);

// The number of characters of UTF-8 text.
size_t LetterCount(std::string_view text);

}  // namespace sweepstake::cli::html
