// Values as text in the audit log, and back: nothing is lost, on any platform. Pure functions.
//
// Doubles are the shortest text that reads back as the same bits (std::to_chars); NaN and
// infinities are text, too. An absent optional is empty, a tuple's members are separated by colons,
// a list's items by spaces. Parse returns whether the whole text was such a value.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

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

// Takes what stands before the first `separator` off `text`: all of it where there is none.
inline std::string_view TakeItem(std::string_view& text, char separator) {
  const size_t length = text.find(separator);
  const std::string_view item = text.substr(0, length);
  text = length == std::string_view::npos ? std::string_view() : text.substr(length + 1);
  return item;
}

// As many members as the tuple has, into what it refers to.
template <typename... Ts>
bool ParseText(std::string_view text, const std::tuple<Ts&...>& values) {
  size_t colon_count = 0;
  for (const char c : text) colon_count += c == ':' ? 1 : 0;
  if (colon_count + 1 != sizeof...(Ts)) return false;
  return std::apply([&](Ts&... each) { return (ParseText(TakeItem(text, ':'), each) && ...); },
                    values);
}

}  // namespace sweepstake::decision
