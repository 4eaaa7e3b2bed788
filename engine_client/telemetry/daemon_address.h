// HOST:PORT of a daemon.
#pragma once

#include <string_view>

#include "sweepstake/status.h"

namespace sweepstake {

// A host name, IPv4 address or [IPv6 address], and a port of 1 to 65535. kInvalidArgument says what
// is wrong.
Status ValidateDaemonAddress(std::string_view address);

}  // namespace sweepstake
