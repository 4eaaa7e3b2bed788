// A file that appears under its name only when it is complete: it is written to a temporary file
// beside it, which Commit renames. Not thread-safe. The destructor removes a file that was not
// committed.
#pragma once

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

class WholeFile {
 public:
  // Opens the temporary file, so that most errors appear before long work begins. Error:
  // kInvalidArgument (`path` is not a regular file, or it cannot be written).
  static Result<std::unique_ptr<WholeFile>> Create(std::filesystem::path path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void Write(std::string_view bytes);
  // Writes a line of CSV (RFC 4180).
  void WriteRow(std::initializer_list<std::string_view> cells);
  // Renames the temporary file to its final name. Error: kInvalidArgument (it could not be
  // written).
  Status Commit();

 private:
  explicit WholeFile(std::filesystem::path path);

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  std::ofstream file_;
};

// Writes a file with this content. Errors: those of WholeFile.
Status WriteWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace sweepstake::cli
