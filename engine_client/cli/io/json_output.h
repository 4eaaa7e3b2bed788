// Prints the result of a command: one JSON document with --json, otherwise text.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>

#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

using Json = nlohmann::ordered_json;  // keeps the order of the fields

// Prints `document` and a line break. An `indent` of -1 prints everything on one line. Bytes that
// are not UTF-8, such as those of some file names, become U+FFFD.
void PrintJson(const Json& document, std::ostream& out, int indent = 2);

// Prints `text` (whole lines) on `terminal.out` and flushes it.
void PrintText(Terminal& terminal, const std::string& text);

// Prints `document` (as PrintJson does) if `as_json`, otherwise `text` (whole lines), on
// `terminal.out`.
void PrintResult(Terminal& terminal, bool as_json, const Json& document, const std::string& text,
                 int indent = 2);

// Returns the value, or null if it is absent.
template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

// Returns the JSON array [low, high].
inline Json IntervalJson(const Interval& interval) { return {interval.low, interval.high}; }

}  // namespace sweepstake::cli
