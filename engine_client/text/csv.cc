#include "engine_client/text/csv.h"

namespace sweepstake::text {

void AppendCsv(std::string& out, std::string_view cell) {
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += cell;
    return;
  }
  out += '"';
  for (const char c : cell) out.append(c == '"' ? 2 : 1, c);
  out += '"';
}

bool CsvReader::Next(std::vector<std::string>& cells) {
  if (at_ == text_.size() || !problem_.empty()) return false;
  line_ = next_line_;
  size_t count = 0;
  bool more = true;
  while (more) {
    if (count == cells.size()) cells.emplace_back();
    if (!ReadCell(cells[count++])) return false;
    more = at_ < text_.size() && text_[at_] == ',';
    if (more) ++at_;
  }
  cells.resize(count);
  SkipLineEnd();
  return true;
}

bool CsvReader::ReadCell(std::string& cell) {
  cell.clear();
  if (at_ < text_.size() && text_[at_] == '"') {
    if (!ReadQuoted(cell)) return false;
  } else {
    const size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ',' && text_[at_] != '"' && !AtLineEnd()) ++at_;
    cell.assign(text_.substr(begin, at_ - begin));
  }
  if (at_ == text_.size() || text_[at_] == ',' || AtLineEnd()) return true;
  problem_ = "a quote is inside an unquoted cell, or text follows a closing quote";
  return false;
}

// Reads from the opening quote to the position after the closing one.
bool CsvReader::ReadQuoted(std::string& cell) {
  while (true) {
    const size_t quote = text_.find('"', ++at_);
    if (quote == std::string_view::npos) {
      problem_ = "a quoted cell has no closing quote";
      return false;
    }
    for (; at_ < quote; ++at_) {
      next_line_ += text_[at_] == '\n' ? 1 : 0;
      cell += text_[at_];
    }
    ++at_;
    if (at_ == text_.size() || text_[at_] != '"') return true;
    cell += '"';
  }
}

bool CsvReader::AtLineEnd() const {
  return text_[at_] == '\n' ||
         (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n');
}

void CsvReader::SkipLineEnd() {
  if (at_ == text_.size()) return;
  at_ += text_[at_] == '\r' ? 2 : 1;
  ++next_line_;
}

}  // namespace sweepstake::text
