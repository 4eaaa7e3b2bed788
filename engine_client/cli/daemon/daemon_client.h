// What all calls to a daemon share: opening a channel, setting a deadline and translating statuses.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns a channel to HOST:PORT, which connects at its first call. Error: kInvalidArgument (the
// address does not have this form). Channels to one address share a connection unless
// `own_connection` is set.
Result<std::shared_ptr<grpc::Channel>> OpenChannel(const std::string& address,
                                                   bool own_connection = false);

// Makes the call fail with kUnavailable after ten seconds.
void SetDeadline(grpc::ClientContext& context);

// Returns the daemon's status, or kUnavailable with a hint if the daemon could not be reached.
Status ToStatus(const grpc::Status& status, const std::string& address);

}  // namespace sweepstake::cli
