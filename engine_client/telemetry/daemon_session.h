// Makes a session with a daemon, for a program whose command-line options do not have the names of
// the fields of SessionOptions.
#pragma once

#include <memory>
#include <string>

#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/session.h"

namespace sweepstake {

// Works like MakeDaemonSession of session.h, but error messages use `names` for the TLS options.
Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options,
                                                   const TlsNames& names);

}  // namespace sweepstake
