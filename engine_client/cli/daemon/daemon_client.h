// What all calls to a daemon share: opening a channel, setting a deadline and translating statuses.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns a channel to the daemon, which connects at its first call. Error: kInvalidArgument (the
// address is not HOST:PORT, or the files of TLS cannot be used). Channels to one address share a
// connection in plain text, unless `own_connection` is set.
Result<std::shared_ptr<grpc::Channel>> OpenChannel(const DaemonOptions& daemon,
                                                   bool own_connection = false);

// Makes the call fail with kUnavailable after ten seconds.
void SetDeadline(grpc::ClientContext& context);

// Returns the daemon's status, or kUnavailable with a hint if the daemon could not be reached.
Status ToStatus(const grpc::Status& status, const DaemonOptions& daemon);

}  // namespace sweepstake::cli
