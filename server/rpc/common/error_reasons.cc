#include "server/rpc/common/error_reasons.h"

#include <string>

#include "absl/strings/strip.h"

namespace sweepstake::rpc {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";

absl::StatusCode CodeOf(v1::ErrorReason reason) {
  for (const sessions::Reason& known : sessions::reasons::kAll) {
    if (known.name == NameOf(reason)) return known.code;
  }
  switch (reason) {
    case v1::ERROR_REASON_MALFORMED_MESSAGE:
    case v1::ERROR_REASON_UNKNOWN_POLICY:
    case v1::ERROR_REASON_TIME_SCALE:
      return absl::StatusCode::kInvalidArgument;
    case v1::ERROR_REASON_MESSAGE_ORDER:
    case v1::ERROR_REASON_PROTOCOL_VERSION:
      return absl::StatusCode::kFailedPrecondition;
    case v1::ERROR_REASON_CALL_STALLED:
      return absl::StatusCode::kDeadlineExceeded;
    case v1::ERROR_REASON_MESSAGE_COMPRESSED:
      return absl::StatusCode::kUnimplemented;
    case v1::ERROR_REASON_MESSAGE_TOO_LONG:
    case v1::ERROR_REASON_TOO_MANY_STREAMS:
    case v1::ERROR_REASON_TOO_MANY_IMPORTS:
    case v1::ERROR_REASON_IMPORT_TOO_LARGE:
    case v1::ERROR_REASON_WATCHER_STALLED:
    case v1::ERROR_REASON_TOO_MANY_FAILURES:
    case v1::ERROR_REASON_TOO_MANY_MESSAGES:
    case v1::ERROR_REASON_TOO_MANY_READS:
    case v1::ERROR_REASON_TOO_MANY_HELLOS:
    case v1::ERROR_REASON_TOO_MANY_SILENCES:
      return absl::StatusCode::kResourceExhausted;
    case v1::ERROR_REASON_TOKEN_MISSING:
    case v1::ERROR_REASON_TOKEN_REFUSED:
      return absl::StatusCode::kUnauthenticated;
    case v1::ERROR_REASON_NOT_ALLOWED:
      return absl::StatusCode::kPermissionDenied;
    case v1::ERROR_REASON_UNKNOWN_ALERT:
    case v1::ERROR_REASON_UNKNOWN_SCENE:
      return absl::StatusCode::kNotFound;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::string_view NameOf(v1::ErrorReason reason) {
  return absl::StripPrefix(v1::ErrorReason_Name(reason), "ERROR_REASON_");
}

absl::Status Refused(v1::ErrorReason reason, absl::string_view message) {
  return sessions::Refused({NameOf(reason), CodeOf(reason)}, message);
}

v1::ErrorReason ReasonOfRefusal(const absl::Status& status) {
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  v1::ErrorReason_Parse("ERROR_REASON_" + sessions::ReasonNameOf(status), &reason);
  return reason;
}

absl::Status StoreFailed(const absl::Status& status) {
  if (absl::IsCancelled(status)) {
    return Refused(v1::ERROR_REASON_DRAINING,
                   "the daemon is draining; nothing was changed; try again later");
  }
  // The store returns INVALID_ARGUMENT if the client sent an invalid record.
  return sessions::WithReason(status, absl::IsInvalidArgument(status)
                                          ? sessions::reasons::kInvalidMessage.name
                                          : sessions::reasons::kStoreFailed.name);
}

void CountError(const absl::Status& status, Counters& counters) {
  const v1::ErrorReason reason = ReasonOfRefusal(status);
  if (reason != v1::ERROR_REASON_UNSPECIFIED || !(status.ok() || absl::IsCancelled(status)))
    ++counters.error_counts.at(reason);
}

grpc::Status ToGrpc(const absl::Status& status, Counters& counters) {
  CountError(status, counters);
  const auto code = static_cast<grpc::StatusCode>(status.code());
  const v1::ErrorReason reason = ReasonOfRefusal(status);
  if (reason == v1::ERROR_REASON_UNSPECIFIED) return {code, std::string(status.message())};
  v1::ErrorInfo error;
  error.set_reason(std::string(NameOf(reason)));
  error.set_domain("sweepstake");
  v1::StatusDetails details;
  details.set_code(code);
  details.set_message(std::string(status.message()));
  google::protobuf::Any& info = *details.add_details();
  info.set_type_url(kErrorInfoUrl);
  info.set_value(error.SerializeAsString());
  return {code, details.message(), details.SerializeAsString()};
}

}  // namespace sweepstake::rpc
