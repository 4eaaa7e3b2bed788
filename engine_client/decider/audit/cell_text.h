// Values as text in the audit log, and back, without loss on any platform. Pure functions.
//
// A double is the shortest text that reads back as the same bits (std::to_chars); NaN and
// infinities have a text too. An absent optional is empty, a tuple's members are separated by
// colons, and an enumeration is its word, or its number if it has none. The Parse functions return
// whether the whole text was such a value.
#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine_client/decider/types.h"

namespace sweepstake::decision {

template <typename T>
concept AuditNumber = (std::integral<T> || std::same_as<T, double>)&&!std::same_as<T, bool>;

template <AuditNumber T>
void AppendText(std::string& out, T value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  out.append(text, end.ptr);
}

inline void AppendText(std::string& out, bool value) { out += value ? '1' : '0'; }

template <typename T>
void AppendText(std::string& out, const std::optional<T>& value) {
  if (value) AppendText(out, *value);
}

template <typename... Ts>
void AppendText(std::string& out, const std::tuple<Ts...>& values) {
  const auto append = [&](const auto& first, const auto&... rest) {
    AppendText(out, first);
    ((out += ':', AppendText(out, rest)), ...);
  };
  std::apply(append, values);
}

template <AuditNumber T>
bool ParseText(std::string_view text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

inline bool ParseText(std::string_view text, bool& value) {
  value = text == "1";
  return value || text == "0";
}

template <typename T>
bool ParseText(std::string_view text, std::optional<T>& value) {
  value.reset();
  return text.empty() || ParseText(text, value.emplace());
}

// Removes the part of `text` before the first `separator`, and the separator, and returns that
// part. Without a separator it is the whole text.
inline std::string_view TakeItem(std::string_view& text, char separator) {
  const size_t length = text.find(separator);
  const std::string_view item = text.substr(0, length);
  text = length == std::string_view::npos ? std::string_view() : text.substr(length + 1);
  return item;
}

// Parses exactly as many members as the tuple has into what it refers to.
template <typename... Ts>
bool ParseText(std::string_view text, const std::tuple<Ts&...>& values) {
  size_t colon_count = 0;
  for (const char c : text) colon_count += c == ':' ? 1 : 0;
  if (colon_count + 1 != sizeof...(Ts)) return false;
  return std::apply([&](Ts&... each) { return (ParseText(TakeItem(text, ':'), each) && ...); },
                    values);
}

enum class AuditKind : uint32_t {
  kSetup,
  kTick,
  kBailOut,
  kSwitch,
  kRefusal,
  kMode,
  kMissing,
  kOrder,
  kAdmin
};

// As the names in engine_client/decider/types.h: by value.
inline constexpr std::array<std::string_view, 9> kAuditKindNames = {
    "setup", "tick", "bail-out", "switch", "refusal", "mode", "missing", "order", "admin"};

template <typename Enum>
void AppendName(std::string& out, std::span<const std::string_view> names, Enum value) {
  const auto number = static_cast<uint32_t>(value);
  if (number < names.size() && !names[number].empty()) {
    out += names[number];
  } else {
    AppendText(out, number);
  }
}

template <typename Enum>
std::string NameOf(std::span<const std::string_view> names, Enum value) {
  std::string name;
  AppendName(name, names, value);
  return name;
}

template <typename Enum>
bool ParseName(std::string_view text, std::span<const std::string_view> names, Enum& value) {
  for (size_t i = 0; i < names.size() && !text.empty(); ++i) {
    if (names[i] != text) continue;
    value = static_cast<Enum>(i);
    return true;
  }
  uint32_t number = 0;
  if (!ParseText(text, number)) return false;
  value = static_cast<Enum>(number);
  return true;
}

}  // namespace sweepstake::decision
