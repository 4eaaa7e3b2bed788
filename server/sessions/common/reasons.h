// The reasons why a session, or a call about a session, is refused or ended. Programs decide by the
// reason what to do. Pure functions.
#pragma once

#include <array>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/string_view.h"

namespace sweepstake::sessions {

struct Reason {
  absl::string_view name;  // name of a v1::ErrorReason, without its prefix
  absl::StatusCode code;
};

namespace reasons {

inline constexpr Reason kInvalidMessage{"INVALID_MESSAGE", absl::StatusCode::kInvalidArgument};
inline constexpr Reason kOrderRefused{"ORDER_REFUSED", absl::StatusCode::kFailedPrecondition};
inline constexpr Reason kBoxesNotShown{"BOXES_NOT_SHOWN", absl::StatusCode::kFailedPrecondition};
inline constexpr Reason kOrderUnanswered{"ORDER_UNANSWERED", absl::StatusCode::kDeadlineExceeded};
inline constexpr Reason kTooManySessions{"TOO_MANY_SESSIONS", absl::StatusCode::kResourceExhausted};
inline constexpr Reason kTooManyWatchers{"TOO_MANY_WATCHERS", absl::StatusCode::kResourceExhausted};
inline constexpr Reason kTooManyProjects{"TOO_MANY_PROJECTS", absl::StatusCode::kResourceExhausted};
inline constexpr Reason kTooManyScenes{"TOO_MANY_SCENES", absl::StatusCode::kResourceExhausted};
inline constexpr Reason kTooManyArms{"TOO_MANY_ARMS", absl::StatusCode::kResourceExhausted};
inline constexpr Reason kSessionTakenOver{"SESSION_TAKEN_OVER", absl::StatusCode::kAborted};
inline constexpr Reason kOrderReplaced{"ORDER_REPLACED", absl::StatusCode::kAborted};
inline constexpr Reason kDraining{"DRAINING", absl::StatusCode::kUnavailable};
inline constexpr Reason kConnectionKicked{"CONNECTION_KICKED", absl::StatusCode::kUnavailable};
inline constexpr Reason kStoreBusy{"STORE_BUSY", absl::StatusCode::kUnavailable};
inline constexpr Reason kStoreFailed{"STORE_FAILED", absl::StatusCode::kUnavailable};
inline constexpr Reason kGameAway{"GAME_AWAY", absl::StatusCode::kUnavailable};
inline constexpr Reason kUnknownSession{"UNKNOWN_SESSION", absl::StatusCode::kNotFound};
inline constexpr Reason kSessionKicked{"SESSION_KICKED", absl::StatusCode::kPermissionDenied};
inline constexpr Reason kForeignSession{"FOREIGN_SESSION", absl::StatusCode::kPermissionDenied};

inline constexpr std::array kAll = {
    kInvalidMessage,  kOrderRefused,    kBoxesNotShown,    kOrderUnanswered, kTooManySessions,
    kTooManyWatchers, kTooManyProjects, kTooManyScenes,    kTooManyArms,     kSessionTakenOver,
    kOrderReplaced,   kDraining,        kConnectionKicked, kStoreBusy,       kStoreFailed,
    kGameAway,        kUnknownSession,  kSessionKicked,    kForeignSession};

}  // namespace reasons

// The key under which a status stores the name of its reason, as a payload
// (absl::Status::SetPayload).
inline constexpr absl::string_view kReasonPayload = "sweepstake/reason";

// Returns the status with another reason and the same code.
inline absl::Status WithReason(absl::Status status, absl::string_view name) {
  status.SetPayload(kReasonPayload, absl::Cord(name));
  return status;
}

// Returns a status with the reason, and with the status code of that reason. `message` must say
// what to do next.
inline absl::Status Refused(const Reason& reason, absl::string_view message) {
  return WithReason(absl::Status(reason.code, message), reason.name);
}

// Returns the name of the status's reason; empty if it has none.
inline std::string ReasonNameOf(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kReasonPayload);
  return payload ? std::string(*payload) : std::string();
}

}  // namespace sweepstake::sessions
