// A file that appears whole or not at all: written beside its place and renamed when it is
// complete. Not thread-safe. What is not committed is removed with the object.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake::cli {

class WholeFile {
 public:
  // Begins to write; finds out now what would fail later. kInvalidArgument: `path` is a folder or
  // something else that is no file, or cannot be written.
  static Result<std::unique_ptr<WholeFile>> Create(std::filesystem::path path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void Write(std::string_view bytes);
  // Gives the file its name; kInvalidArgument: could not be written.
  Status Commit();

 private:
  explicit WholeFile(std::filesystem::path path);

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  std::ofstream file_;
};

}  // namespace sweepstake::cli
