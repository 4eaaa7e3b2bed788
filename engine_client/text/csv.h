// CSV by RFC 4180, in memory. Not thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sweepstake::text {

// Appends the cell, in quotes if it contains a comma, a quote or a line break.
void AppendCsv(std::string& out, std::string_view cell);

// Appends the cells, separated by commas.
template <typename Cells>
void AppendCsvLine(std::string& out, const Cells& cells) {
  const char* separator = "";
  for (const std::string_view cell : cells) {
    AppendCsv(out += separator, cell);
    separator = ",";
  }
}

// Reads record by record. Lines end with LF or CR LF. The last line may lack its line break.
class CsvReader {
 public:
  // `text` must outlive the reader.
  explicit CsvReader(std::string_view text) : text_(text) {}

  // Reads the cells of the next record. Returns false at the end of the text and after an error
  // (problem()).
  bool Next(std::vector<std::string>& cells);

  // Line number at which the latest record begins, from 1.
  size_t line() const { return line_; }
  // The error, or empty if there was none.
  const std::string& problem() const { return problem_; }

 private:
  bool ReadCell(std::string& cell);
  bool ReadQuoted(std::string& cell);
  bool AtLineEnd() const;
  void SkipLineEnd();

  std::string_view text_;
  size_t at_ = 0;
  size_t line_ = 0;       // line where the record begins
  size_t next_line_ = 1;  // line of at_
  std::string problem_;
};

}  // namespace sweepstake::text
