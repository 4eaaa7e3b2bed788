// CSV by RFC 4180, in memory. Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::decision {

// The cell, in quotes where it holds a comma, a quote or a line break.
void AppendCsv(std::string& out, std::string_view cell);

// Reads record by record. Lines end with LF or CR LF; one at the end of the text may be missing.
class CsvReader {
 public:
  // `text` must outlive the reader.
  explicit CsvReader(std::string_view text) : text_(text) {}

  // The next record's cells; false at the end, and where the text is wrong (see problem()).
  bool Next(std::vector<std::string>& cells);

  // Of the record read last; from 1.
  size_t line() const { return line_; }
  // Empty: none.
  const std::string& problem() const { return problem_; }

 private:
  bool ReadCell(std::string& cell);
  bool ReadQuoted(std::string& cell);
  bool AtLineEnd() const;
  void SkipLineEnd();

  std::string_view text_;
  size_t at_ = 0;
  size_t line_ = 0;       // where the record begins
  size_t next_line_ = 1;  // at at_
  std::string problem_;
};

}  // namespace sweepstake::decision
