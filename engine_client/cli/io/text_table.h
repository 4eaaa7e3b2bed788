// A table for people: columns aligned, numbers to the right, two spaces apart.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace sweepstake::cli {

class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header);

  // REQUIRES: as many cells as the header has.
  void AddRow(std::vector<std::string> cells);
  // A line of its own across the columns, after an empty one: the title of the rows that follow.
  // REQUIRES: more than one column.
  void AddTitle(std::string title);
  void Print(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;  // a title has one cell
};

// `value` with `decimals` digits after the point.
std::string Fixed(double value, int decimals);

}  // namespace sweepstake::cli
