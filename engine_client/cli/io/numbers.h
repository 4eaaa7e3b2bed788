// Numbers as people read them. Pure functions, safe from any thread. What is no finite number is
// "–".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::cli::html {

// `digits` significant ones, without an exponent: 0.0345, 12.3, 1230. REQUIRES: 1 <= digits <= 9.
std::string Significant(double value, int digits = 3);

// "12,345,678".
std::string Grouped(uint64_t value);
// The same of the nearest whole number. REQUIRES: 0 <= value < 2^63.
std::string GroupedWhole(double value);

// For axes and narrow columns: "800", "1k", "2.5k", "100k", "1M".
std::string Compact(double value);

// "512 B", "11.2 kB", "3.40 MB": powers of 1000.
std::string Bytes(double bytes);

// Characters of UTF-8 text.
size_t LetterCount(std::string_view text);

}  // namespace sweepstake::cli::html
