#include "server/rpc/common/error_reasons.h"

#include <string>

#include "absl/strings/cord.h"
#include "absl/strings/strip.h"

namespace sweepstake::rpc {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";

absl::StatusCode CodeOf(v1::ErrorReason reason) {
  switch (reason) {
    case v1::ERROR_REASON_MALFORMED_MESSAGE:
    case v1::ERROR_REASON_INVALID_MESSAGE:
    case v1::ERROR_REASON_UNKNOWN_POLICY:
    case v1::ERROR_REASON_TIME_SCALE:
      return absl::StatusCode::kInvalidArgument;
    case v1::ERROR_REASON_MESSAGE_ORDER:
    case v1::ERROR_REASON_PROTOCOL_VERSION:
    case v1::ERROR_REASON_ORDER_REFUSED:
    case v1::ERROR_REASON_BOXES_NOT_SHOWN:
      return absl::StatusCode::kFailedPrecondition;
    case v1::ERROR_REASON_HELLO_OVERDUE:
    case v1::ERROR_REASON_CALL_STALLED:
    case v1::ERROR_REASON_ORDER_UNANSWERED:
      return absl::StatusCode::kDeadlineExceeded;
    case v1::ERROR_REASON_TOO_MANY_STREAMS:
    case v1::ERROR_REASON_TOO_MANY_SESSIONS:
    case v1::ERROR_REASON_TOO_MANY_WATCHERS:
    case v1::ERROR_REASON_TOO_MANY_IMPORTS:
    case v1::ERROR_REASON_IMPORT_TOO_LARGE:
    case v1::ERROR_REASON_WATCHER_STALLED:
    case v1::ERROR_REASON_TOO_MANY_FAILURES:
    case v1::ERROR_REASON_TOO_MANY_SCENES:
    case v1::ERROR_REASON_TOO_MANY_ARMS:
    case v1::ERROR_REASON_TOO_MANY_MESSAGES:
    case v1::ERROR_REASON_TOO_MANY_READS:
    case v1::ERROR_REASON_TOO_MANY_PROJECTS:
    case v1::ERROR_REASON_TOO_MANY_HELLOS:
      return absl::StatusCode::kResourceExhausted;
    case v1::ERROR_REASON_TOKEN_MISSING:
    case v1::ERROR_REASON_TOKEN_REFUSED:
      return absl::StatusCode::kUnauthenticated;
    case v1::ERROR_REASON_NOT_ALLOWED:
    case v1::ERROR_REASON_FOREIGN_SESSION:
      return absl::StatusCode::kPermissionDenied;
    case v1::ERROR_REASON_SESSION_TAKEN_OVER:
    case v1::ERROR_REASON_ORDER_REPLACED:
      return absl::StatusCode::kAborted;
    case v1::ERROR_REASON_DRAINING:
    case v1::ERROR_REASON_STORE_BUSY:
    case v1::ERROR_REASON_CONNECTION_KICKED:
    case v1::ERROR_REASON_STORE_FAILED:
    case v1::ERROR_REASON_GAME_AWAY:
      return absl::StatusCode::kUnavailable;
    case v1::ERROR_REASON_UNKNOWN_SCENE:
    case v1::ERROR_REASON_UNKNOWN_SESSION:
      return absl::StatusCode::kNotFound;
    case v1::ERROR_REASON_SESSION_KICKED:
      return absl::StatusCode::kPermissionDenied;
    default:
      return absl::StatusCode::kInternal;
  }
}

// The reason travels with the status as the bytes that the client gets.
absl::Status WithReason(absl::Status status, v1::ErrorReason reason) {
  v1::ErrorInfo info;
  info.set_reason(std::string(NameOf(reason)));
  info.set_domain("sweepstake");
  status.SetPayload(kErrorInfoUrl, absl::Cord(info.SerializeAsString()));
  return status;
}

v1::ErrorReason ReasonIn(const std::string& error_info) {
  v1::ErrorInfo info;
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  if (info.ParseFromString(error_info)) {
    v1::ErrorReason_Parse("ERROR_REASON_" + info.reason(), &reason);
  }
  return reason;
}

}  // namespace

absl::string_view NameOf(v1::ErrorReason reason) {
  return absl::StripPrefix(v1::ErrorReason_Name(reason), "ERROR_REASON_");
}

absl::Status Refused(v1::ErrorReason reason, absl::string_view message) {
  return WithReason(absl::Status(CodeOf(reason), message), reason);
}

v1::ErrorReason ReasonOfRefusal(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kErrorInfoUrl);
  return payload ? ReasonIn(std::string(*payload)) : v1::ERROR_REASON_UNSPECIFIED;
}

absl::Status StoreFailed(const absl::Status& status) {
  // What it refuses is a record of the client.
  return WithReason(status, absl::IsInvalidArgument(status) ? v1::ERROR_REASON_INVALID_MESSAGE
                                                            : v1::ERROR_REASON_STORE_FAILED);
}

grpc::Status ToGrpc(const absl::Status& status, Counters& counters) {
  const auto code = static_cast<grpc::StatusCode>(status.code());
  const absl::optional<absl::Cord> payload = status.GetPayload(kErrorInfoUrl);
  if (!payload) {
    if (!status.ok() && !absl::IsCancelled(status)) {
      ++counters.error_counts.at(v1::ERROR_REASON_UNSPECIFIED);
    }
    return {code, std::string(status.message())};
  }
  const std::string error_info(*payload);
  ++counters.error_counts.at(ReasonIn(error_info));
  v1::StatusDetails details;
  details.set_code(code);
  details.set_message(std::string(status.message()));
  google::protobuf::Any& info = *details.add_details();
  info.set_type_url(kErrorInfoUrl);
  info.set_value(error_info);
  return {code, details.message(), details.SerializeAsString()};
}

}  // namespace sweepstake::rpc
