#include "server/web/query.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "absl/strings/str_split.h"

namespace sweepstake::web {

absl::StatusOr<std::string> PercentDecoded(std::string_view text) {
  std::string decoded;
  while (!text.empty()) {
    char c = text.front();
    size_t length = 1;
    if (c == '%') {
      uint8_t byte = 0;
      length = 3;
      const char* end = text.data() + std::min(length, text.size());
      const auto [stop, error] = std::from_chars(text.data() + 1, end, byte, 16);
      if (text.size() < length || stop != text.data() + length)
        return absl::InvalidArgumentError("the address has a % without two hexadecimal digits");
      c = static_cast<char>(byte);
    }
    decoded += c;
    text.remove_prefix(length);
  }
  return decoded;
}

absl::StatusOr<std::string> QueryValue(std::string_view query, std::string_view name) {
  for (const absl::string_view part :
       absl::StrSplit(absl::string_view(query.data(), query.size()), '&')) {
    const std::string_view pair(part.data(), part.size());
    if (!pair.starts_with(name) || !pair.substr(name.size()).starts_with('=')) continue;
    std::string value(pair.substr(name.size() + 1));
    std::replace(value.begin(), value.end(), '+', ' ');
    return PercentDecoded(value);
  }
  return std::string();
}

}  // namespace sweepstake::web
