// The audit log as a CSV file (RFC 4180, UTF-8), for `sweepstake audit export` and `run --csv`.
//
// There is one column per field; the name of a nested field is the path to it, joined by
// underscores. A row of the log has one line, and one more for each further item of its longest
// list: the column `item` counts them from 0, and an item's line repeats only the session, the
// segment and the row. A field that does not apply to its row is empty. Numbers are the shortest
// decimal text that reads back as the same bits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/audit/audit_row.h"
#include "engine_client/decider/audit/csv.h"

namespace sweepstake::decision {

// The names of the columns, `item` first.
const std::vector<std::string>& AuditColumns();

// Returns the cells of a row, line by line.
std::vector<std::vector<std::string>> AuditCells(const AuditRow& row);

// Return the header line and the lines of a row, without the last line end.
std::string AuditHeader();
std::string AuditLines(const AuditRow& row);

// Reads a file that AuditLines has written, row by row. Not linked by games, because not every
// standard library has the std::from_chars for floating-point numbers that it uses.
class AuditCsvReader {
 public:
  // `csv` must outlive the reader.
  explicit AuditCsvReader(std::string_view csv);

  // Returns false at the end and if the file is wrong (problem()).
  bool Next(AuditRow& row);

  // The first line of the latest row, from 1.
  size_t line() const { return line_; }
  // Empty if there is none; if it is about one cell, column() is its name.
  const std::string& problem() const { return problem_; }
  const std::string& column() const { return column_; }

 private:
  // Moves `ahead_` to the next line. Returns false at the end and if the line is wrong.
  bool ReadAhead();

  CsvReader lines_;
  size_t line_ = 0;
  std::vector<std::string> ahead_;  // the first line of the next row; empty at the end
  std::string problem_;
  std::string column_;
};

}  // namespace sweepstake::decision
