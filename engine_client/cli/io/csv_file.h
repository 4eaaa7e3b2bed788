// A CSV file (RFC 4180) that appears under its name only when it is complete. Not thread-safe. The
// destructor removes a file that was not committed.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string_view>
#include <utility>

#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

class CsvFile {
 public:
  // Begins the file with the header line. Errors: those of WholeFile::Create.
  static Result<std::unique_ptr<CsvFile>> Create(std::filesystem::path path,
                                                 std::initializer_list<std::string_view> header);

  void Row(std::initializer_list<std::string_view> cells);
  // Makes the file appear under its name. Error: kInvalidArgument (it could not be written).
  Status Commit() { return file_->Commit(); }

 private:
  explicit CsvFile(std::unique_ptr<WholeFile> file) : file_(std::move(file)) {}

  std::unique_ptr<WholeFile> file_;
};

}  // namespace sweepstake::cli
