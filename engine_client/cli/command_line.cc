#include "engine_client/cli/command_line.h"

#include <string_view>

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
    // A quote cannot stand inside of quotes: they end, it follows escaped, and they begin again.
    if (character == '\'') {
      quoted += "'\\''";
    } else {
      quoted += character;
    }
  }
  return quoted + '\'';
}

}  // namespace

std::string CommandLine(std::span<char* const> words) {
  std::string line;
  for (const char* word : words) {
    if (!line.empty()) line += ' ';
    line += Quoted(word);
  }
  return line;
}

}  // namespace sweepstake::cli
