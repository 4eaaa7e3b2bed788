// Writes frames.csv with a row per frame. Call it between frames, so that its time does not count
// as frame time. The file appears under its name only after Commit. Not thread-safe.
#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "engine_client/cli/io/csv_file.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

class FrameLog {
 public:
  // Has the errors of CsvFile::Create.
  static Result<std::unique_ptr<FrameLog>> Create(const std::filesystem::path& path);

  void Write(const FrameSample& sample, const AdaptiveBroadPhase& adaptive);
  Status Commit() { return csv_->Commit(); }

 private:
  explicit FrameLog(std::unique_ptr<CsvFile> csv) : csv_(std::move(csv)) {}
  std::unique_ptr<CsvFile> csv_;
};

}  // namespace sweepstake::cli
