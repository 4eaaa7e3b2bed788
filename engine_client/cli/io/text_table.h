// Formats tables and numbers as text. Columns are separated by two spaces, and columns of numbers
// are aligned right.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::cli {

class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header);

  // Adds a row. REQUIRES: it has as many cells as the header.
  void AddRow(std::vector<std::string> cells);
  // Adds an empty line and then a title, which spans all columns, for the rows that follow.
  // REQUIRES: more than one column.
  void AddTitle(std::string title);
  // Returns all lines, each with its line break.
  std::string Text() const;
  void Print(std::ostream& out) const { out << Text(); }

 private:
  // Returns the widths of the columns in characters.
  std::vector<size_t> Widths() const;
  // Returns, for each column, whether it has only numbers.
  std::vector<bool> AlignedRight() const;
  bool IsTitle(const std::vector<std::string>& row) const { return row.size() < rows_[0].size(); }

  // The first row is the header. A title is a row of one cell.
  std::vector<std::vector<std::string>> rows_;
};

// Returns `value` with `decimals` digits after the point. A value that rounds to 0 has no sign.
std::string Fixed(double value, int decimals);

// Returns 100 times `ratio` with `decimals` digits after the point: "12.3 %".
std::string Percent(double ratio, int decimals);

// Returns the number of characters (not bytes) of UTF-8 text.
size_t LetterCount(std::string_view text);

}  // namespace sweepstake::cli
