#include "server/rpc/common/message_validation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/text/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/options.h"
#include "server/rpc/common/proto_conversion.h"

namespace sweepstake::rpc {
namespace {

using text::IsName;
using text::IsOptionalName;

constexpr uint64_t kMaxSequence = (1ull << 63) - 1;
// Maximum number of dropped frames in one report: two years at 1,000 frames/s. The 64-bit counter
// can hold the sum of 2^28 such reports.
constexpr uint64_t kMaxDroppedFrames = 1ull << 36;
constexpr uint64_t kMaxFrameIndex = 1ull << 63;

absl::Status Invalid(absl::string_view message) {
  return Refused(v1::ERROR_REASON_INVALID_MESSAGE, message);
}

absl::Status InvalidName(absl::string_view field) {
  return Invalid(absl::StrCat(field, " must have 1 to 128 bytes and no control characters"));
}

absl::Status CheckArm(uint32_t arm, uint32_t arm_count) {
  if (arm < arm_count) return absl::OkStatus();
  return Invalid(
      absl::StrCat("arm ", arm, " does not exist; Hello announced ", arm_count, " arms"));
}

absl::Status CheckTimeScale(double scale, double max) {
  // The valid range is tested and then negated, so that NaN is refused.
  if (!(scale == 0 || (scale >= 1 && scale <= kMaxTimeScale)))
    return Invalid(absl::StrCat("time_scale must be 1 to ", kMaxTimeScale, ", or absent"));
  if (scale <= max) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_TIME_SCALE,
                 absl::StrCat("this daemon allows a time scale up to ", max, ", not ", scale,
                              "; use a smaller one, or start the daemon with --max-time-scale ",
                              std::ceil(scale)));
}

absl::Status CheckVersion(const v1::Hello& hello) {
  if (hello.protocol_version() == protocol::kVersion) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_PROTOCOL_VERSION,
                 absl::StrCat("this daemon has version ", protocol::kVersion,
                              " of the protocol, the client has version ", hello.protocol_version(),
                              "; update the older side"));
}

absl::Status CheckArms(const v1::Hello& hello) {
  if (hello.arms().empty() || hello.arms_size() > static_cast<int>(decision::kMaxArms)) {
    return Invalid(absl::StrCat("Hello must announce 1 to ", decision::kMaxArms, " arms, not ",
                                hello.arms_size()));
  }
  std::set<std::string_view> names;
  for (const v1::Arm& arm : hello.arms()) {
    if (!IsName(arm.name())) return InvalidName("an arm's name");
    if (arm.backend_version() == 0)
      return Invalid(absl::StrCat("backend_version of arm ", arm.name(), " is absent"));
    if (!names.insert(arm.name()).second)
      return Invalid(absl::StrCat("arm ", arm.name(), " is announced twice"));
  }
  const auto arm_count = static_cast<uint32_t>(hello.arms_size());
  if (absl::Status status = CheckArm(hello.active_arm(), arm_count); !status.ok()) return status;
  return CheckArm(hello.initial_arm(), arm_count);
}

absl::Status CheckNames(const v1::Hello& hello) {
  if (!IsName(hello.project())) return InvalidName("project");
  if (!IsName(hello.scene())) return InvalidName("scene");
  if (!IsOptionalName(hello.build())) return InvalidName("build");
  if (!IsOptionalName(hello.machine_class())) return InvalidName("machine_class");
  if (!IsOptionalName(hello.session_id())) return InvalidName("session_id");
  if (!IsOptionalName(hello.policy())) return InvalidName("policy");
  return absl::OkStatus();
}

absl::Status CheckPolicy(const std::string& policy) {
  const auto valid = decision::PolicyNames(decision::ShippedPolicies());
  if (std::find(valid.begin(), valid.end(), policy) != valid.end()) return absl::OkStatus();
  return Refused(v1::ERROR_REASON_UNKNOWN_POLICY, text::UnknownName("policy", policy, valid));
}

absl::Status CheckRules(const DecisionRules& rules) {
  const auto problems = decision::NumberProblems(decision::DecisionOptions().With(rules));
  if (!problems.empty()) return Invalid(problems.front());
  if (rules.decision_interval_ns.value_or(kMinDecisionIntervalNs) >= kMinDecisionIntervalNs)
    return absl::OkStatus();
  return Invalid(absl::StrCat("decision_interval_ns is ", *rules.decision_interval_ns,
                              "; a daemon decides at most four times a second, so use ",
                              kMinDecisionIntervalNs, " or more"));
}

absl::Status CheckColumns(const v1::FrameBatch& batch) {
  const int count = batch.frame_time_ns_size();
  if (count < 1 || count > static_cast<int>(kMaxBatchFrames)) {
    return Invalid(
        absl::StrCat("a frame batch must hold 1 to ", kMaxBatchFrames, " frames, not ", count));
  }
  for (const int length : {batch.detection_time_ns_size(), batch.aabb_check_count_size(),
                           batch.native_bytes_size(), batch.object_count_size(), batch.arm_size(),
                           batch.switch_epoch_size(), batch.flags_size()}) {
    if (length != count) {
      return Invalid(
          absl::StrCat("the columns of a frame batch differ in length: ", count, " and ", length));
    }
  }
  if (batch.dropped_frame_count() > kMaxDroppedFrames)
    return Invalid("dropped_frame_count must be at most 2^36");
  if (batch.first_frame_index() > kMaxFrameIndex)
    return Invalid("first_frame_index must be at most 2^63");
  return absl::OkStatus();
}

absl::Status CheckShadows(const v1::FrameBatch& batch, uint32_t arm_count) {
  if (batch.shadow_samples_size() > static_cast<int>(kMaxBatchShadows)) {
    return Invalid(absl::StrCat("a frame batch may hold ", kMaxBatchShadows,
                                " shadow samples, not ", batch.shadow_samples_size()));
  }
  for (const v1::ShadowSample& sample : batch.shadow_samples()) {
    if (absl::Status status = CheckArm(sample.arm(), arm_count); !status.ok()) return status;
    if (sample.detection_time_ns() == 0)
      return Invalid("detection_time_ns of a shadow sample is absent");
  }
  return absl::OkStatus();
}

absl::Status CheckFrameBatch(const v1::FrameBatch& batch, uint32_t arm_count) {
  if (absl::Status status = CheckColumns(batch); !status.ok()) return status;
  for (const uint32_t arm : batch.arm()) {
    if (absl::Status status = CheckArm(arm, arm_count); !status.ok()) return status;
  }
  return CheckShadows(batch, arm_count);
}

absl::Status CheckModeChange(const v1::ModeChange& change, uint32_t arm_count) {
  if (change.mode() == v1::MODE_UNSPECIFIED)
    return Invalid("mode is absent; set MODE_MANUAL or MODE_AI");
  return CheckArm(change.active_arm(), arm_count);
}

absl::Status CheckSwitchOutcome(const v1::SwitchOutcome& outcome, uint32_t arm_count) {
  if (outcome.reason() == v1::SWITCH_REASON_UNSPECIFIED)
    return Invalid("reason of the switch outcome is absent");
  if (absl::Status status = CheckArm(outcome.trial_arm(), arm_count); !status.ok()) return status;
  return CheckArm(outcome.arm(), arm_count);
}

absl::Status CheckBoxView(const v1::BoxView& view) {
  const bool fits = view.boxes().size() + view.pairs().size() <= sessions::kMaxBoxViewBytes &&
                    view.boxes().size() % 12 == 0 && view.pairs().size() % 4 == 0;
  if (!fits) return Invalid("a box view has a wrong number of bytes");
  const bool has_bounds = view.bounds_size() == (view.boxes().empty() ? 0 : 6) &&
                          std::all_of(view.bounds().begin(), view.bounds().end(),
                                      [](float v) { return std::isfinite(v); });
  return has_bounds ? absl::OkStatus() : Invalid("a box view has boxes without finite bounds");
}

absl::Status CheckSequence(const v1::StreamTelemetryRequest& request) {
  if (request.has_goodbye() || request.has_box_view()) return absl::OkStatus();
  if (request.sequence() >= 1 && request.sequence() <= kMaxSequence) return absl::OkStatus();
  return Invalid("sequence must be 1 to 2^63 - 1 in every message but Hello, Goodbye and BoxView");
}

}  // namespace

absl::Status CheckHello(const v1::Hello& hello, const RpcOptions& options) {
  if (absl::Status status = CheckVersion(hello); !status.ok()) return status;
  if (absl::Status status = CheckNames(hello); !status.ok()) return status;
  if (absl::Status status = CheckArms(hello); !status.ok()) return status;
  if (absl::Status status = CheckPolicy(hello.policy()); !status.ok()) return status;
  if (absl::Status status = CheckRules(RulesOf(hello)); !status.ok()) return status;
  if (hello.mode() == v1::MODE_UNSPECIFIED || !v1::Mode_IsValid(hello.mode()))
    return Invalid("mode is absent or unknown; set MODE_MANUAL or MODE_AI");
  return CheckTimeScale(hello.time_scale(), options.max_time_scale);
}

absl::Status CheckRequest(const v1::StreamTelemetryRequest& request, uint32_t arm_count) {
  if (request.has_hello())
    return Refused(v1::ERROR_REASON_MESSAGE_ORDER,
                   "Hello was already sent on this stream; send it once, as the first message");
  // A message of a newer protocol appears as an unknown field and is allowed.
  if (request.message_case() == v1::StreamTelemetryRequest::MESSAGE_NOT_SET &&
      request.GetReflection()->GetUnknownFields(request).empty())
    return Invalid("the request contains no message");
  if (absl::Status status = CheckSequence(request); !status.ok()) return status;
  switch (request.message_case()) {
    case v1::StreamTelemetryRequest::kFrameBatch:
      return CheckFrameBatch(request.frame_batch(), arm_count);
    case v1::StreamTelemetryRequest::kSwitchOutcome:
      return CheckSwitchOutcome(request.switch_outcome(), arm_count);
    case v1::StreamTelemetryRequest::kBailOut:
      return CheckArm(request.bail_out().arm(), arm_count);
    case v1::StreamTelemetryRequest::kModeChange:
      return CheckModeChange(request.mode_change(), arm_count);
    case v1::StreamTelemetryRequest::kBoxView:
      return CheckBoxView(request.box_view());
    default:
      return absl::OkStatus();
  }
}

absl::Status CheckPriorRecord(const v1::PriorRecord& record) {
  if (!IsName(record.project())) return InvalidName("project");
  if (!IsName(record.scene())) return InvalidName("scene");
  if (!IsName(record.arm())) return InvalidName("arm");
  if (!IsName(record.source_id())) return InvalidName("source_id");
  if (!decision::IsMeasuredBy(record.measured_by())) return InvalidName("measured_by");
  if (!IsOptionalName(record.machine_class())) return InvalidName("machine_class");
  if (!decision::MiddleOf(record.regime()))
    return Invalid("regime must be absent or numbers such as 13/-4/0");
  if (!IsOptionalName(record.build())) return InvalidName("build");
  if (record.unix_last_seen_s() < 0) return Invalid("unix_last_seen_s must not be negative");
  return absl::OkStatus();
}

}  // namespace sweepstake::rpc
