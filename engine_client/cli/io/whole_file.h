// A file that appears under its name only when it is complete. It is written to a temporary file in
// the same folder, which Commit renames. If Commit is not called, the destructor removes the file.
// Not thread-safe.
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
  // Opens the temporary file at once, so that most errors appear before long work begins. Error:
  // kInvalidArgument if `path` is not a regular file or cannot be written.
  static Result<std::unique_ptr<WholeFile>> Create(std::filesystem::path path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void Write(std::string_view bytes);
  // Writes a line of CSV (RFC 4180).
  void WriteRow(std::initializer_list<std::string_view> cells);
  // Renames the temporary file to its final name. Error: kInvalidArgument if writing failed.
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
