// The session with a daemon of session.h, for a caller whose options have names of their own.
#pragma once

#include <memory>
#include <string>

#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/session.h"

namespace sweepstake {

// As MakeDaemonSession of session.h; its error and the errors of the session call the options of
// TLS by `names`.
Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options,
                                                   const TlsNames& names);

}  // namespace sweepstake
