// The cells of the audit log that hold more than one value: the members of the input structs, the
// summary of the arms' runs (session/arm_runs.h), and a session's setup. Pure functions.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

// Each FieldsOf returns references to every member in the order of declaration. It names every
// member, so that a new one does not compile until it is in the log.
template <typename T, typename Value>
concept EitherConst = std::same_as<std::remove_const_t<T>, Value>;

// Decisions do not depend on the frame's index and its pairs, which are not logged.
template <EitherConst<FrameSample> T>
auto FieldsOf(T& frame) {
  auto& [index, frame_time_ns, detection_time_ns, check_count, native_bytes, pair_count,
         object_count, arm, epoch, flags, reserved] = frame;
  return std::tie(frame_time_ns, detection_time_ns, check_count, native_bytes, object_count, arm,
                  epoch, flags);
}

template <EitherConst<TrialEnd> T>
auto FieldsOf(T& end) {
  auto& [arm, detection_time_ns] = end;
  return std::tie(arm, detection_time_ns);
}

template <EitherConst<ShadowSample> T>
auto FieldsOf(T& sample) {
  auto& [first_frame_index, detection_time_ns, build_time_ns, check_count, native_bytes, arm,
         object_count, frame_count, flags] = sample;
  return std::tie(first_frame_index, detection_time_ns, build_time_ns, check_count, native_bytes,
                  arm, object_count, frame_count, flags);
}

template <EitherConst<SceneDescriptor> T>
auto FieldsOf(T& scene) {
  auto& [object_count, density, size_spread, speed_mean, speed_spread, clustering, static_ratio] =
      scene;
  return std::tie(object_count, density, size_spread, speed_mean, speed_spread, clustering,
                  static_ratio);
}

// The cell of the arms' runs, such as "1 2:5:…", has up to three items. The first is 1 if the
// current tick has had frames of the active run, otherwise 0. The second holds the members of the
// active run, those of its window last. The third holds the members of the later run, if frames of
// one have arrived.
void AppendRuns(std::string& out, const ArmRuns& runs);

// Returns nothing if the text cannot be the runs of a session with `arm_count` arms, or if a sum is
// negative or not finite.
std::optional<ArmRuns> ParseRuns(std::string_view text, uint32_t arm_count);

// The setup's cell has key=value pairs in a fixed order, separated by semicolons. Items of a list
// are separated by commas. In a text each of \ ; , has a backslash before it. The session's id and
// the segment have columns of their own.
void AppendSetup(std::string& out, const SessionSetup& setup, const AuditOrigin& origin);

// Appends a text, escaped in this way.
void AppendEscaped(std::string& out, std::string_view text);

// Precedes the operator's name in the setup column of an order.
inline constexpr std::string_view kOperatorKey = "operator=";

struct AuditSetup {
  SessionSetup setup;
  AuditOrigin origin;
};
// If it returns nothing, `problem` says what is wrong.
std::optional<AuditSetup> ParseSetup(std::string_view text, std::string& problem);

}  // namespace sweepstake::decision
