#include "engine_client/text/names.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace sweepstake::text {
namespace {

constexpr size_t kMaxLineBytes = 200;
constexpr size_t kMaxNearest = 3;

// Returns the Levenshtein distance. It fills the table of distances between all prefixes row by
// row.
size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j < row.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replaced}));
    }
  }
  return row.back();
}

// Returns the length in bytes of the UTF-8 sequence that begins with `lead`; 0 if no sequence
// begins with it.
size_t SequenceLength(uint8_t lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead < 0xE0) return 2;
  if (lead >= 0xE0 && lead < 0xF0) return 3;
  if (lead >= 0xF0 && lead < 0xF5) return 4;
  return 0;
}

// Returns false for overlong forms, surrogates, code points above U+10FFFF, and control characters.
bool IsPrintable(uint32_t code_point, size_t length) {
  constexpr uint32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code_point < kMin[length] || code_point > 0x10FFFF) return false;
  if (code_point >= 0xD800 && code_point < 0xE000) return false;
  return code_point >= 0x20 && (code_point < 0x7F || code_point >= 0xA0);
}

// Consumes one printable character; returns false if there is none.
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

bool IsName(std::string_view text) { return !text.empty() && IsOptionalName(text); }

bool IsOptionalName(std::string_view text) { return text.size() <= kMaxNameBytes && IsLine(text); }

bool IsLine(std::string_view text) {
  while (!text.empty()) {
    if (!TakeCharacter(text)) return false;
  }
  return true;
}

std::string PrintableLine(std::string_view text) {
  std::string line(text.substr(0, kMaxLineBytes));
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return line;
}

std::string PrintableLines(std::string_view text) {
  std::string lines;
  while (!text.empty()) {
    std::string_view rest = text;
    const bool is_kept = text.front() == '\n' || TakeCharacter(rest);
    const size_t length = is_kept && text.front() != '\n' ? text.size() - rest.size() : 1;
    lines += is_kept ? text.substr(0, length) : "?";
    text.remove_prefix(length);
  }
  return lines;
}

std::string_view NearestName(std::string_view name, std::span<const std::string_view> valid) {
  const auto nearest =
      std::min_element(valid.begin(), valid.end(), [name](std::string_view a, std::string_view b) {
        return EditDistance(name, a) < EditDistance(name, b);
      });
  return nearest == valid.end() ? std::string_view() : *nearest;
}

std::string UnknownName(std::string_view kind, std::string_view name,
                        std::span<const std::string_view> valid) {
  const std::string shown = PrintableLine(name);
  const std::string_view nearest = NearestName(shown, valid);
  std::string message = "unknown ";
  message.append(kind).append(" '").append(shown).append("', must be one of ").append(nearest);
  for (const std::string_view each : valid) {
    if (each != nearest) message.append(", ").append(each);
  }
  return message;
}

std::string UnknownNameOfMany(std::string_view kind, std::string_view name,
                              std::span<const std::string_view> valid) {
  const std::string shown = PrintableLine(name);
  const size_t distance = EditDistance(shown, NearestName(shown, valid));
  std::string nearest;
  size_t count = 0;
  for (const std::string_view each : valid) {
    if (count == kMaxNearest || EditDistance(shown, each) != distance) continue;
    nearest.append(count++ == 0 ? "" : ", ").append(each);
  }
  std::string message = "unknown ";
  message.append(kind).append(" '").append(shown).append("', the nearest ");
  message.append(count == 1 ? "is " : "are ").append(nearest);
  return message.append("; --help lists all");
}

}  // namespace sweepstake::text
