// Checks of the caller's arguments: the address of a daemon, the options of a session. Pure
// functions.
#pragma once

#include <string_view>

#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// An address is HOST:PORT: a host name, an IPv4 address or an [IPv6 address], and a port of 1 to
// 65535. kInvalidArgument says what is wrong.
Status ValidateDaemonAddress(std::string_view address);

// The files are not read. kInvalidArgument names the option and its bounds.
Status ValidateTlsOptions(const TlsOptions& options);

// kInvalidArgument names the option and its bounds.
Status ValidateSessionOptions(const SessionOptions& options);

}  // namespace sweepstake
