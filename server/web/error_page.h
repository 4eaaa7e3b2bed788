// How the API says that something went wrong: as gRPC does, in JSON, with the HTTP status that
// comes nearest to the code. Pure functions.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

// Returns a status of the daemon's services as one of absl's, the bytes of its google.rpc.ErrorInfo
// as a payload, as the services have it before it becomes gRPC's.
absl::Status FromGrpc(const grpc::Status& status);

// Returns {"error":{"code":"NOT_FOUND","reason":"UNKNOWN_SCENE","message":"…"}}. The reason is that
// of the status' ErrorInfo, or empty.
std::string ErrorJson(const absl::Status& status);
Page ErrorPage(const absl::Status& status);

}  // namespace sweepstake::web
