// Paths in the API are UTF-8 on every platform. These functions convert them to the system's paths
// and back to text, without exceptions. Pure functions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine_client/text/names.h"

namespace sweepstake {

// Returns nothing for text that is not UTF-8 or holds a control character.
inline std::optional<std::filesystem::path> PathOfUtf8(std::string_view text) {
  if (!text::IsLine(text)) return std::nullopt;
  return std::filesystem::path(std::u8string(text.begin(), text.end()));
}

// Returns the path as text, for messages.
inline std::string PathText(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return text::PrintableLine({reinterpret_cast<const char*>(text.data()), text.size()});
}

}  // namespace sweepstake
