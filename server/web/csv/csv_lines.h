// Writes the lines of a CSV file (RFC 4180) for spreadsheets and programs: plain numbers, times in
// ISO 8601, and texts that no spreadsheet runs as a formula. Not thread-safe.
#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sweepstake::web {

class CsvLines {
 public:
  // Writes a text. A text that a spreadsheet would read as a formula gets a leading apostrophe.
  void Text(std::string_view text);
  // Writes a number as the shortest text that reads back as the same value.
  template <typename Value>
  requires std::integral<Value> || std::floating_point<Value>
  void Number(Value value) {
    char text[32];
    Cell({text, static_cast<size_t>(std::to_chars(text, text + sizeof text, value).ptr - text)});
  }
  template <typename Value>
  void Number(const std::optional<Value>& value) {
    value ? Number(*value) : Nothing();
  }
  // Writes a time such as 2026-03-01T14:05:09.125Z; nothing for 0, which stands for unknown.
  void Time(int64_t unix_ms);
  // Leaves cells empty.
  void Nothing(int count = 1);
  void End();

  // Returns the lines so far, and forgets them.
  std::string Take();

 private:
  void Cell(std::string_view cell);

  std::string lines_;
  bool is_first_ = true;  // of the cells of the line
};

}  // namespace sweepstake::web
