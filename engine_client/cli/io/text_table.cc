#include "engine_client/cli/io/text_table.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "engine_client/cli/io/numbers.h"

namespace sweepstake::cli {
namespace {

bool IsNumber(const std::string& cell) {
  return !cell.empty() && cell.find_first_not_of("+-.0123456789e%") == std::string::npos;
}

}  // namespace

TextTable::TextTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void TextTable::AddRow(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

void TextTable::AddTitle(std::string title) { rows_.push_back({std::move(title)}); }

void TextTable::Print(std::ostream& out) const {
  std::vector<size_t> widths(rows_.front().size());
  std::vector<bool> right(widths.size(), rows_.size() > 1);
  for (size_t row = 0; row < rows_.size(); ++row) {
    if (rows_[row].size() < widths.size()) continue;
    for (size_t column = 0; column < widths.size(); ++column) {
      const std::string& cell = rows_[row][column];
      widths[column] = std::max(widths[column], html::LetterCount(cell));
      if (row > 0 && !IsNumber(cell)) right[column] = false;
    }
  }
  for (const auto& row : rows_) {
    if (row.size() < widths.size()) {
      out << '\n' << row.front() << '\n';
      continue;
    }
    std::string line;
    for (size_t column = 0; column < widths.size(); ++column) {
      const std::string padding(widths[column] - html::LetterCount(row[column]), ' ');
      line += right[column] ? padding + row[column] : row[column] + padding;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  }
}

std::string Fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

}  // namespace sweepstake::cli
