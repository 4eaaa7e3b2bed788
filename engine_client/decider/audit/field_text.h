// Converts a field of the audit log to text and back. No value changes on the way, on any platform.
// Pure functions.
//
// A double becomes the shortest text that reads back as the same bits (std::to_chars). An
// enumeration value becomes its name, or its number if it has no name.
#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "engine_client/decider/audit/audit_row.h"

namespace sweepstake::decision {

constexpr std::span<const std::string_view> NamesOf(AuditKind) { return kAuditKindNames; }
constexpr std::span<const std::string_view> NamesOf(Mode) { return kModeNames; }
constexpr std::span<const std::string_view> NamesOf(SwitchReason) { return kSwitchReasonNames; }
constexpr std::span<const std::string_view> NamesOf(DecisionOutcome) { return kOutcomeNames; }
constexpr std::span<const std::string_view> NamesOf(Verdict) { return kVerdictNames; }

template <typename T>
std::string FieldText(const T& value) {
  if constexpr (std::same_as<T, std::string>) {
    return value;
  } else if constexpr (std::is_enum_v<T>) {
    return value == T{} ? "" : NameOf(NamesOf(value), value);
  } else if constexpr (std::same_as<T, bool>) {
    return value ? "1" : "0";
  } else {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
  }
}

// Parses the text into `value`. Returns false if it is invalid. Empty text changes nothing.
template <typename T>
bool ReadField(std::string_view text, T& value) {
  if (text.empty()) return true;
  if constexpr (std::same_as<T, std::string>) {
    value = text;
    return true;
  } else if constexpr (std::is_enum_v<T>) {
    const auto names = NamesOf(value);
    uint32_t number = 0;
    while (number < names.size() && names[number] != text) ++number;
    const bool is_known = number < names.size() || ReadField(text, number);
    value = static_cast<T>(number);
    return is_known;
  } else if constexpr (std::same_as<T, bool>) {
    value = text == "1";
    return value || text == "0";
  } else {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end;
  }
}

}  // namespace sweepstake::decision
