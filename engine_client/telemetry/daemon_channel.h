// Makes a channel to a daemon, in plain text or with TLS, for sessions and for the command line.
// Interprets the channel's errors. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/session.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake {

// Returns a channel to `address`, HOST:PORT. It connects at its first call, and every call sends
// the token. The files of `tls` and `token` are read now. `arguments` are extra channel arguments.
// Messages refer to the options by `names`; no message contains the token. Error kInvalidArgument:
// - the address, the TLS options or files, or the token are invalid
// - the token would cross a network in plain text
Result<std::shared_ptr<grpc::Channel>> MakeDaemonChannel(const std::string& address,
                                                         const std::optional<TlsOptions>& tls,
                                                         const ClientToken& token,
                                                         const TlsNames& names,
                                                         grpc::ChannelArguments arguments);

// Returns advice for the user about a failed connection; empty if `reason` needs no addition.
// `reason` is gRPC's message. The advice refers to the options by `names`.
std::string ConnectionAdvice(const std::string& reason, bool with_tls, const TlsNames& names);

// Returns why the daemon refused a call or ended a stream (errors.proto). ERROR_REASON_UNSPECIFIED
// if the status contains no reason or one that only newer versions define.
v1::ErrorReason ReasonOf(const grpc::Status& status);

// Returns the daemon's own status if the details contain it (protocol::StatusIn), else `status`.
// The message then ends with the reason's name in brackets: "... (DRAINING)".
grpc::Status WithReason(const grpc::Status& status);

}  // namespace sweepstake
