// Converts paths of the API, which are UTF-8 on every platform, to paths of the system and back to
// text. These functions do not throw. Pure functions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine_client/text/names.h"

namespace sweepstake {

// Returns the path, or nothing if the text is not UTF-8 or contains a control character.
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
