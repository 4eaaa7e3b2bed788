#include "engine_client/cli/html/markup.h"

#include <cstdint>

namespace sweepstake::cli::html {
namespace {

constexpr std::string_view kReplacement = "\uFFFD";

bool IsContinuation(char byte) { return (static_cast<uint8_t>(byte) & 0xC0U) == 0x80U; }

// Bytes of the UTF-8 character that `text` starts with (RFC 3629), 0 when it is none.
size_t CharacterLength(std::string_view text) {
  const auto lead = static_cast<uint8_t>(text[0]);
  if (lead < 0x80) return 1;
  const size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  for (size_t i = 1; i < length; ++i) {
    if (!IsContinuation(text[i])) return 0;
  }
  const auto second = static_cast<uint8_t>(text[1]);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second >= 0xA0;
  const bool too_large = lead == 0xF4 && second >= 0x90;
  return overlong || surrogate || too_large ? 0 : length;
}

std::string_view EscapedAscii(const char& character) {
  switch (character) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default: {
      const bool control =
          (character >= 0 && character < ' ' && character != '\n' && character != '\t') ||
          character == '\x7f';
      return control ? kReplacement : std::string_view(&character, 1);
    }
  }
}

std::string Open(std::string_view name, const Attributes& attributes) {
  std::string html = "<" + std::string(name);
  for (const auto& [key, value] : attributes) {
    html += " " + std::string(key) + "=\"" + Escape(value) + "\"";
  }
  return html;
}

}  // namespace

Markup::Markup(std::string_view text) : html_(Escape(text)) {}

Markup Markup::Trusted(std::string html) {
  Markup markup;
  markup.html_ = std::move(html);
  return markup;
}

Markup& Markup::operator+=(const Markup& more) {
  html_ += more.html_;
  return *this;
}

Markup operator+(Markup first, const Markup& second) { return first += second; }

Markup Element(std::string_view name, const Attributes& attributes, const Markup& content) {
  return Markup::Trusted(Open(name, attributes) + ">" + content.html() + "</" + std::string(name) +
                         ">");
}

Markup Element(std::string_view name, const Attributes& attributes) {
  return Markup::Trusted(Open(name, attributes) + "/>");
}

std::string Escape(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  while (!text.empty()) {
    const size_t length = CharacterLength(text);
    if (length <= 1) {
      escaped += length == 0 ? kReplacement : EscapedAscii(text[0]);
    } else {
      escaped += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

Markup EmbeddedJson(std::string_view json) {
  // "<" occurs only inside of JSON's strings, where \u003c is the same.
  std::string embedded;
  for (const char character : json) {
    if (character == '<') {
      embedded += "\\u003c";
    } else {
      embedded += character;
    }
  }
  return Markup::Trusted(std::move(embedded));
}

}  // namespace sweepstake::cli::html
