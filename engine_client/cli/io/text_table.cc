#include "engine_client/cli/io/text_table.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace sweepstake::cli {
namespace {

bool IsNumber(const std::string& cell) {
  return !cell.empty() && cell.find_first_not_of("+-.0123456789e%") == std::string::npos;
}

}  // namespace

TextTable::TextTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void TextTable::AddRow(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

void TextTable::AddTitle(std::string title) { rows_.push_back({std::move(title)}); }

std::vector<size_t> TextTable::Widths() const {
  std::vector<size_t> widths(rows_[0].size());
  for (const auto& row : rows_) {
    if (IsTitle(row)) continue;
    for (size_t column = 0; column < widths.size(); ++column) {
      widths[column] = std::max(widths[column], LetterCount(row[column]));
    }
  }
  return widths;
}

std::vector<bool> TextTable::AlignedRight() const {
  std::vector<bool> right(rows_[0].size(), rows_.size() > 1);
  for (size_t i = 1; i < rows_.size(); ++i) {
    if (IsTitle(rows_[i])) continue;
    for (size_t column = 0; column < right.size(); ++column) {
      if (!IsNumber(rows_[i][column])) right[column] = false;
    }
  }
  return right;
}

std::string TextTable::Text() const {
  const std::vector<size_t> widths = Widths();
  const std::vector<bool> right = AlignedRight();
  std::string text;
  for (const auto& row : rows_) {
    if (IsTitle(row)) {
      text += '\n' + row.front() + '\n';
      continue;
    }
    std::string line;
    for (size_t column = 0; column < widths.size(); ++column) {
      const std::string padding(widths[column] - LetterCount(row[column]), ' ');
      line += right[column] ? padding + row[column] : row[column] + padding;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string Fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  const std::string_view all = text;
  const bool is_zero = all.starts_with('-') && all.find_first_not_of("-0.") == all.npos;
  return text + (is_zero ? 1 : 0);  // 0 has no sign
}

std::string Percent(double ratio, int decimals) { return Fixed(100 * ratio, decimals) + " %"; }

size_t LetterCount(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

}  // namespace sweepstake::cli
