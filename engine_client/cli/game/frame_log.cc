#include "engine_client/cli/game/frame_log.h"

#include <string>

namespace sweepstake::cli {

Result<std::unique_ptr<FrameLog>> FrameLog::Create(const std::filesystem::path& path) {
  auto csv = CsvFile::Create(
      path, {"frame", "arm", "switch_epoch", "frame_time_ns", "detection_time_ns",
             "aabb_check_count", "pair_count", "object_count", "native_bytes", "flags"});
  if (!csv.ok()) return csv.status();
  return std::unique_ptr<FrameLog>(new FrameLog(std::move(*csv)));
}

void FrameLog::Write(const FrameSample& sample, const AdaptiveBroadPhase& adaptive) {
  csv_->Row({std::to_string(sample.frame_index), adaptive.arms()[sample.arm],
             std::to_string(sample.switch_epoch), std::to_string(sample.frame_time_ns),
             std::to_string(sample.detection_time_ns), std::to_string(sample.aabb_check_count),
             std::to_string(sample.pair_count), std::to_string(sample.object_count),
             std::to_string(sample.native_bytes), std::to_string(sample.flags)});
}

}  // namespace sweepstake::cli
