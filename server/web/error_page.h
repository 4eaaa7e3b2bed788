// Converts errors of gRPC to JSON, with the HTTP status that is closest to the code. Pure
// functions.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

// Returns {"error":{"code":"NOT_FOUND","reason":"UNKNOWN_SCENE","message":"…"}}. The reason is
// empty if the status has none.
std::string ErrorJson(const absl::Status& status);
Page ErrorPage(const absl::Status& status);

}  // namespace sweepstake::web
