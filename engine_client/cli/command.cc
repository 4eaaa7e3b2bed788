#include "engine_client/cli/command.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "server/decision/math/names.h"

namespace sweepstake::cli {
namespace {

constexpr std::string_view kHarmless =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";

std::string Quoted(std::string_view word) {
  if (!word.empty() && word.find_first_not_of(kHarmless) == std::string_view::npos) {
    return std::string(word);
  }
  std::string quoted = "'";
  for (const char character : word) {
    // A single quote cannot stand inside single quotes: it closes them, follows escaped, and opens
    // them again.
    if (character == '\'') {
      quoted += "'\\''";
    } else {
      quoted += character;
    }
  }
  return quoted + '\'';
}

}  // namespace

CLI::Validator WholeUpTo(uint64_t max) { return CLI::Range(uint64_t{0}, max); }

CLI::Validator RealFrom(double min, double max) {
  CLI::Validator range = CLI::Range(min, max);
  return {[=](std::string& text) {
            double value = 0;
            const bool is_number = CLI::detail::lexical_cast(text, value);
            return is_number && std::isnan(value) ? text + " is no number" : range(text);
          },
          range.get_description()};
}

CLI::Validator NotNegative() {
  return {[](const std::string& text) {
            return text.starts_with('-') ? text + " is negative" : std::string();
          },
          "UINT64"};
}

CLI::Validator OneOf(std::span<const std::string_view> words) {
  std::string all;
  for (const std::string_view word : words) all.append(all.empty() ? "{" : ",").append(word);
  return {[words](const std::string& text) {
            return std::find(words.begin(), words.end(), text) == words.end()
                       ? math::UnknownName("value", text, words)
                       : std::string();
          },
          all + "}"};
}

void AddDaemonOption(CLI::App& command, std::string& address) {
  command.add_option("--daemon", address, "Address of sweepstaked, HOST:PORT")->required();
}

void AddJsonFlag(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "One JSON document on stdout");
}

void AddSeedOption(CLI::App& command, uint64_t& seed, const std::string& purpose) {
  command.add_option("--seed", seed, "Seed of " + purpose)
      ->check(NotNegative())
      ->capture_default_str();
}

std::string CommandLine(std::span<char* const> words) {
  std::string line;
  for (const char* word : words) {
    if (!line.empty()) line += ' ';
    line += Quoted(word);
  }
  return line;
}

}  // namespace sweepstake::cli
