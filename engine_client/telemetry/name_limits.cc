#include "engine_client/telemetry/name_limits.h"

#include <cstdint>

namespace sweepstake {
namespace {

// Bytes of the UTF-8 sequence that begins with `lead`; 0 for a byte that begins none.
size_t SequenceLength(uint8_t lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  if (lead >= 0xF0 && lead < 0xF5) return 4;
  return 0;
}

// Rejects overlong forms, surrogates, what lies beyond U+10FFFF, and control characters.
bool IsPrintable(uint32_t code_point, size_t length) {
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code_point < kLeast[length] || code_point > 0x10FFFF) return false;
  if (code_point >= 0xD800 && code_point < 0xE000) return false;
  return code_point >= 0x20 && (code_point < 0x7F || code_point >= 0xA0);
}

// Consumes one printable character; false where there is none.
bool TakeCharacter(std::string_view& text) {
  const auto lead = static_cast<uint8_t>(text.front());
  const size_t length = SequenceLength(lead);
  if (length == 0 || length > text.size()) return false;
  uint32_t code_point = length == 1 ? lead : lead & (0x7FU >> length);
  for (size_t i = 1; i < length; ++i) {
    const auto next = static_cast<uint8_t>(text[i]);
    if ((next & 0xC0) != 0x80) return false;
    code_point = code_point << 6 | (next & 0x3F);
  }
  text.remove_prefix(length);
  return IsPrintable(code_point, length);
}

}  // namespace

bool IsName(std::string_view text) {
  if (text.size() > kNameBytesMax) return false;
  while (!text.empty()) {
    if (!TakeCharacter(text)) return false;
  }
  return true;
}

}  // namespace sweepstake
