// Numbers as text for people.
//
// Pure functions, safe from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::text {

// Returns the number with commas between thousands: "12,345,678".
std::string Grouped(uint64_t value);

// Returns the number with the noun, in the plural unless the number is 1: "2 sources".
std::string Counted(uint64_t count, std::string_view noun);

}  // namespace sweepstake::text
