// The table of settings: their names, and how each is read and printed. Pure.
#pragma once

#include <charconv>
#include <functional>
#include <string>
#include <system_error>
#include <vector>

#include "absl/status/status.h"
#include "server/config.h"

namespace sweepstake::server {

// Reads a value into the configuration. The error says which values are valid.
using Setter = std::function<absl::Status(Config&, const std::string&)>;
// Returns the value as TOML.
using Getter = std::function<std::string(const Config&)>;

struct Setting {
  std::string key;
  std::string help;
  Setter set;
  Getter get;
  bool is_switch = false;
  bool is_live = false;  // a running daemon takes it over
};

// Returns the settings in the order in which they are printed.
std::vector<Setting> Settings();

template <typename T>
bool ParseNumber(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

// Returns the shortest text that reads back as the same number.
std::string ShortestText(double number);

}  // namespace sweepstake::server
