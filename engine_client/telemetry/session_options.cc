#include "engine_client/telemetry/session_options.h"

#include <bit>

#include "engine_client/telemetry/name_limits.h"
#include "engine_client/telemetry/sample_queue.h"

namespace sweepstake {
namespace {

Status Invalid(std::string_view option, std::string_view rule) {
  return {StatusCode::kInvalidArgument, std::string(option) + " must be " + std::string(rule)};
}

Status ValidateNames(const SessionOptions& options) {
  constexpr std::string_view kRule = "1 to 128 bytes of UTF-8 without control characters";
  constexpr std::string_view kOptionalRule =
      "at most 128 bytes of UTF-8 without control characters";
  if (options.project.empty() || !IsName(options.project)) return Invalid("project", kRule);
  if (options.scene.empty() || !IsName(options.scene)) return Invalid("scene", kRule);
  if (!IsName(options.build)) return Invalid("build", kOptionalRule);
  if (!IsName(options.machine_class)) return Invalid("machine_class", kOptionalRule);
  if (!IsName(options.policy)) return Invalid("policy", kOptionalRule);
  return {};
}

Status ValidateBatching(const SessionOptions& options) {
  if (options.batch_interval_ms < 1 || options.batch_interval_ms > 10'000) {
    return Invalid("batch_interval_ms", "1 to 10000");
  }
  if (options.batch_frames < 1 || options.batch_frames > 240) {
    return Invalid("batch_frames", "1 to 240");
  }
  if (options.batch_bytes < 512 || options.batch_bytes > 256 * 1024) {
    return Invalid("batch_bytes", "512 to 262144");
  }
  return {};
}

}  // namespace

Status ValidateSessionOptions(const SessionOptions& options) {
  if (Status status = ValidateNames(options); !status.ok()) return status;
  if (Status status = ValidateBatching(options); !status.ok()) return status;
  if (!(options.time_scale >= 1 && options.time_scale <= 1000)) {
    return Invalid("time_scale", "1 to 1000");
  }
  if (options.queue_frames < 2 || options.queue_frames > SampleQueue::kFrameCapacityMax ||
      !std::has_single_bit(options.queue_frames)) {
    return Invalid("queue_frames", "a power of two, 2 to 1048576");
  }
  if (options.unacknowledged_messages < 1 || options.unacknowledged_messages > 4096) {
    return Invalid("unacknowledged_messages", "1 to 4096");
  }
  if (options.backoff_min_ms < 1 || options.backoff_max_ms < options.backoff_min_ms ||
      options.backoff_max_ms > 3'600'000) {
    return Invalid("backoff_min_ms and backoff_max_ms", "1 <= min <= max <= 3600000");
  }
  return {};
}

}  // namespace sweepstake
