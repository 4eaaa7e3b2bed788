// Checks of the caller's arguments: names, the address of a daemon, the options of a session. Pure
// functions.
#pragma once

#include <cstddef>
#include <string_view>

#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

inline constexpr size_t kNameBytesMax = 128;

// Checks the rule for every name on the wire and in files: at most kNameBytesMax bytes of UTF-8
// without control characters. The empty name passes; the caller checks whether a name is required.
bool IsName(std::string_view text);

// An address is HOST:PORT: a host name, an IPv4 address or an [IPv6 address], and a port of 1 to
// 65535. kInvalidArgument says what is wrong.
Status ValidateDaemonAddress(std::string_view address);

// kInvalidArgument names the option and its bounds.
Status ValidateSessionOptions(const SessionOptions& options);

}  // namespace sweepstake
