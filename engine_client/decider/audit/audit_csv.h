// The audit log as a CSV file (RFC 4180, UTF-8), for `sweepstake audit export` and `run --csv`.
//
// There is one column per field. The column of a nested field is named by the path to it, joined by
// underscores. Numbers are the shortest decimal text that reads back as the same bits. Fields that
// a row does not use are empty.
//
// Row fields that are lists need several lines: the row has as many lines as its longest list has
// items, and at least one. The column `item` counts them from 0. Lines after the first repeat only
// the session, the segment and the row number.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/audit/audit_row.h"
#include "engine_client/text/csv.h"

namespace sweepstake::decision {

// The names of the columns, `item` first.
const std::vector<std::string>& AuditColumns();

// Returns the cells of a row, line by line.
std::vector<std::vector<std::string>> AuditCells(const AuditRow& row);

// Return the header line, and the lines of a row. Neither ends with a line break.
std::string AuditHeader();
std::string AuditLines(const AuditRow& row);

// Reads, row by row, a file that AuditLines wrote. Games do not link it, because some standard
// libraries lack the std::from_chars for floating-point numbers that it needs.
class AuditCsvReader {
 public:
  // `csv` must outlive the reader.
  explicit AuditCsvReader(std::string_view csv);

  // Reads the next row. Returns false at the end of the file and after an error (problem()).
  bool Next(AuditRow& row);

  // Line number of the latest row's first line; the file begins with line 1.
  size_t line() const { return line_; }
  // The error, or empty if there was none. column() names the cell's column if the error concerns
  // one cell.
  const std::string& problem() const { return problem_; }
  const std::string& column() const { return column_; }

 private:
  // Reads the next line into `ahead_`. Returns false at the end of the file and after an error.
  bool ReadAhead();

  text::CsvReader lines_;
  size_t line_ = 0;
  std::vector<std::string> ahead_;  // the first line of the next row; empty at the end
  std::string problem_;
  std::string column_;
};

}  // namespace sweepstake::decision
