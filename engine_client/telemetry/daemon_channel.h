// A channel to a daemon, in plain text or with TLS, for sessions and for the command line, and what
// its errors say. Thread-safe.
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

// Returns a channel to HOST:PORT, which connects at its first call. Reads the files of `tls` and
// `token` now. Every call sends the token. `arguments` are extra channel arguments.
// kInvalidArgument: the address, the TLS options or files, or the token are invalid, or the token
// would cross a network in plain text. Messages refer to the options by `names`; no message
// contains the token.
Result<std::shared_ptr<grpc::Channel>> MakeDaemonChannel(const std::string& address,
                                                         const std::optional<TlsOptions>& tls,
                                                         const ClientToken& token,
                                                         const TlsNames& names,
                                                         grpc::ChannelArguments arguments);

// Returns advice for the user about a failed connection; empty if `reason` already says everything.
// `reason` is gRPC's message. The advice refers to the options by `names`.
std::string ConnectionAdvice(const std::string& reason, bool with_tls, const TlsNames& names);

// Returns why the daemon refused a call or ended a stream (errors.proto). ERROR_REASON_UNSPECIFIED
// if the status contains no reason or one that only newer versions define.
v1::ErrorReason ReasonOf(const grpc::Status& status);

// Returns the message, with the reason's name in brackets if there is one: "... (DRAINING)".
std::string MessageWithReason(const grpc::Status& status);

}  // namespace sweepstake
