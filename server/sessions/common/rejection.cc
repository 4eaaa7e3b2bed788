#include "server/sessions/common/rejection.h"

namespace sweepstake::sessions {
namespace {

constexpr uint64_t kMinFrameNs = 1'000;
constexpr uint64_t kMaxChecks = 1ull << 60;
constexpr uint64_t kMaxNativeBytes = 1ull << 46;

std::optional<RejectionReason> RejectionOfCounts(uint64_t check_count, uint64_t native_bytes) {
  if (check_count >= kMaxChecks) return RejectionReason::kCheckCount;
  if (native_bytes >= kMaxNativeBytes) return RejectionReason::kNativeBytes;
  return std::nullopt;
}

}  // namespace

std::optional<RejectionReason> RejectionOf(const FrameSample& frame) {
  if (frame.frame_time_ns < kMinFrameNs || frame.frame_time_ns > kMaxFrameNs)
    return RejectionReason::kFrameTime;
  if (frame.detection_time_ns > frame.frame_time_ns + frame.frame_time_ns / 100 + 1'000'000)
    return RejectionReason::kDetectionTime;
  return RejectionOfCounts(frame.aabb_check_count, frame.native_bytes);
}

std::optional<RejectionReason> RejectionOf(const ShadowSample& sample) {
  if (sample.detection_time_ns > kMaxFrameNs) return RejectionReason::kDetectionTime;
  if (sample.build_time_ns > kMaxFrameNs) return RejectionReason::kBuildTime;
  return RejectionOfCounts(sample.aabb_check_count, sample.native_bytes);
}

}  // namespace sweepstake::sessions
