#include "engine_client/cli/io/numbers.h"

#include <algorithm>
#include <cmath>

namespace sweepstake::cli {

std::string Grouped(uint64_t value) {
  std::string text = std::to_string(value);
  for (size_t end = text.size(); end > 3; end -= 3) text.insert(end - 3, ",");
  return text;
}

std::string GroupedWhole(double value) {
  return Grouped(static_cast<uint64_t>(std::llround(value)));
}

size_t LetterCount(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

}  // namespace sweepstake::cli
