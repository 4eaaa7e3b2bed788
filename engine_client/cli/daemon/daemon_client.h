// All calls of a daemon share this: a channel, a deadline, and statuses in our own words.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// A channel to HOST:PORT, which connects on its first call. kInvalidArgument: the address does not
// have this form.
Result<std::shared_ptr<grpc::Channel>> OpenChannel(const std::string& address);

// Lets a call fail with kUnavailable after ten seconds.
void SetDeadline(grpc::ClientContext& context);

// kUnavailable with what to do where the daemon could not be reached, else what the daemon said.
Status ToStatus(const grpc::Status& status, const std::string& address);

}  // namespace sweepstake::cli
