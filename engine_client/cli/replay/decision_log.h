// A file with an audit log (server/decision/audit_log.h): every decision of a run as CSV. Appears
// whole or not at all. Not thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include "engine_client/cli/io/whole_file.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

class DecisionLog {
 public:
  // Begins it with this program's header. The errors of WholeFile::Create.
  static Result<std::unique_ptr<DecisionLog>> Create(const std::filesystem::path& path);
  // Without it: WriteLine gives it its header.
  static Result<std::unique_ptr<DecisionLog>> CreateEmpty(const std::filesystem::path& path);

  void WriteLine(std::string_view line);
  Status Commit() { return file_->Commit(); }

 private:
  explicit DecisionLog(std::unique_ptr<WholeFile> file) : file_(std::move(file)) {}
  std::unique_ptr<WholeFile> file_;
};

}  // namespace sweepstake::cli
