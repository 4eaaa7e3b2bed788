#include "engine_client/text/counts.h"

namespace sweepstake::text {

std::string Grouped(uint64_t value) {
  std::string text = std::to_string(value);
  for (size_t end = text.size(); end > 3; end -= 3) text.insert(end - 3, ",");
  return text;
}

std::string Counted(uint64_t count, std::string_view noun) {
  return Grouped(count).append(" ").append(noun).append(count == 1 ? "" : "s");
}

}  // namespace sweepstake::text
