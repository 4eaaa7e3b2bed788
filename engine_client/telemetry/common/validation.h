// Checks of the caller's arguments: the address of a daemon, the options of a session. Pure
// functions.
#pragma once

#include <string>
#include <string_view>

#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// An address is HOST:PORT: a host name, an IPv4 address or an [IPv6 address], and a port of 1 to
// 65535. kInvalidArgument says what is wrong.
Status ValidateDaemonAddress(std::string_view address);

// What messages call the options of TLS: as here for a program, which sets fields, or as the
// options of a command line.
struct TlsNames {
  std::string tls = "tls";
  std::string ca = "ca_file";
  std::string cert = "cert_file";
  std::string key = "key_file";
  std::string server_name = "server_name";
};

// The files are not read. kInvalidArgument names the option and its bounds.
Status ValidateTlsOptions(const TlsOptions& options, const TlsNames& names = {});

// kInvalidArgument names the option and its bounds.
Status ValidateSessionOptions(const SessionOptions& options, const TlsNames& names = {});

}  // namespace sweepstake
