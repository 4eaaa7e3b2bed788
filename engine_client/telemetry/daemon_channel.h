// A channel to a daemon, in plain text or with TLS, for sessions and for the command line.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Returns a channel to HOST:PORT, which connects at its first call; the files of `tls` and `token`
// are read now, and every call brings the token. `arguments` are added to those that all channels
// have. Error: kInvalidArgument (the address, the options or the files of `tls`, or a token that
// cannot be used or would cross a network in plain text), which calls the options by `names`; no
// message shows the token.
Result<std::shared_ptr<grpc::Channel>> MakeDaemonChannel(const std::string& address,
                                                         const std::optional<TlsOptions>& tls,
                                                         const ClientToken& token,
                                                         const TlsNames& names,
                                                         grpc::ChannelArguments arguments);

// Returns what to do about a connection that could not be made, for a message to people, which
// calls the options by `names`. `reason` is what gRPC says of it. Empty: the reason says all there
// is.
std::string ConnectionAdvice(const std::string& reason, bool with_tls, const TlsNames& names);

}  // namespace sweepstake
