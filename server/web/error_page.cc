#include "server/web/error_page.h"

#include <nlohmann/json.hpp>

#include "absl/strings/cord.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::web {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";

std::string ReasonOf(const absl::Status& status) {
  v1::ErrorInfo info;
  const auto payload = status.GetPayload(kErrorInfoUrl);
  return payload && info.ParseFromString(std::string(*payload)) ? info.reason() : "";
}

int HttpStatusOf(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kAlreadyExists:
      return 409;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kUnimplemented:
      return 501;
    case absl::StatusCode::kUnavailable:
      return 503;
    case absl::StatusCode::kDeadlineExceeded:
      return 504;
    default:
      return 500;
  }
}

}  // namespace

absl::Status FromGrpc(const grpc::Status& status) {
  absl::Status converted(static_cast<absl::StatusCode>(status.error_code()),
                         status.error_message());
  v1::StatusDetails details;
  if (!details.ParseFromString(status.error_details())) return converted;
  for (const google::protobuf::Any& detail : details.details())
    converted.SetPayload(detail.type_url(), absl::Cord(detail.value()));
  return converted;
}

std::string ErrorJson(const absl::Status& status) {
  const nlohmann::ordered_json error = {{"error",
                                         {{"code", absl::StatusCodeToString(status.code())},
                                          {"reason", ReasonOf(status)},
                                          {"message", std::string(status.message())}}}};
  return error.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Page ErrorPage(const absl::Status& status) {
  return {.status = HttpStatusOf(status.code()),
          .body = ErrorJson(status),
          .content_type = "application/json"};
}

}  // namespace sweepstake::web
