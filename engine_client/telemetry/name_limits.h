// The rule for every name on the wire and in files: at most 128 bytes of UTF-8 without control
// characters.
#pragma once

#include <cstddef>
#include <string_view>

namespace sweepstake {

inline constexpr size_t kNameBytesMax = 128;

// The empty name is within the rule; where one is required the caller says so.
bool IsName(std::string_view text);

}  // namespace sweepstake
