// Makes the session with a daemon of session.h, for a program whose command-line options have other
// names than the fields of SessionOptions.
#pragma once

#include <memory>
#include <string>

#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/session.h"

namespace sweepstake {

// As MakeDaemonSession of session.h, but errors refer to the TLS options by `names`.
Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options,
                                                   const TlsNames& names);

}  // namespace sweepstake
