// A CSV file (RFC 4180) that appears whole or not at all.
// Not thread-safe. What is not committed is removed with the object.
#pragma once

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

class CsvFile {
 public:
  // Begins `path` with the header line. kInvalidArgument: cannot be written.
  static Result<std::unique_ptr<CsvFile>> Create(std::filesystem::path path,
                                                 std::initializer_list<std::string_view> header);
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  void Row(std::initializer_list<std::string_view> cells);
  // Gives the file its name; kInvalidArgument: could not be written.
  Status Commit();

 private:
  explicit CsvFile(std::filesystem::path path);

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  std::ofstream file_;
};

// `cell` quoted where it holds a comma, a quote or a line break.
std::string QuoteCsv(std::string_view cell);

}  // namespace sweepstake::cli
