// What the commands that ask a daemon share: a channel, a deadline, and statuses in our words.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// A channel to HOST:PORT; it connects on the first call. kInvalidArgument: no such form of address.
Result<std::shared_ptr<grpc::Channel>> OpenChannel(const std::string& address);

// A call fails with kUnavailable when it takes longer than ten seconds.
void SetDeadline(grpc::ClientContext& context);

// kUnavailable where the daemon could not be reached, with what to do; else what the daemon said.
Status ToStatus(const grpc::Status& status, const std::string& address);

}  // namespace sweepstake::cli
