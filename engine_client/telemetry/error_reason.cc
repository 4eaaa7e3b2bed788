#include "engine_client/telemetry/error_reason.h"

namespace sweepstake {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";

// Returns the reason's name without its prefix; empty if the status has none of this domain.
std::string ReasonNameOf(const grpc::Status& status) {
  v1::StatusDetails details;
  if (!details.ParseFromString(status.error_details())) return "";
  for (const google::protobuf::Any& detail : details.details()) {
    v1::ErrorInfo info;
    if (detail.type_url() == kErrorInfoUrl && info.ParseFromString(detail.value()) &&
        info.domain() == "sweepstake")
      return info.reason();
  }
  return "";
}

}  // namespace

v1::ErrorReason ReasonOf(const grpc::Status& status) {
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  v1::ErrorReason_Parse("ERROR_REASON_" + ReasonNameOf(status), &reason);
  return reason;
}

std::string MessageWithReason(const grpc::Status& status) {
  const std::string name = ReasonNameOf(status);
  return name.empty() ? status.error_message() : status.error_message() + " (" + name + ")";
}

}  // namespace sweepstake
