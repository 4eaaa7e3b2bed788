// Checks of the caller's arguments: the address of a daemon, the options of a session. Pure
// functions.
#pragma once

#include <string>
#include <string_view>

#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Checks an address HOST:PORT: a host name, an IPv4 address or an [IPv6 address], and a port from 1
// to 65535. The message of kInvalidArgument says what is wrong.
Status ValidateDaemonAddress(std::string_view address);

// The names of the TLS options in messages. The defaults are the fields that a program sets; the
// command line passes its own option names.
struct TlsNames {
  std::string tls = "tls";
  std::string ca = "ca_file";
  std::string cert = "cert_file";
  std::string key = "key_file";
  std::string server_name = "server_name";
};

// Checks the options without reading the files. kInvalidArgument names the option and its bounds.
Status ValidateTlsOptions(const TlsOptions& options, const TlsNames& names = {});

// Checks the options. kInvalidArgument names the option and its bounds.
Status ValidateSessionOptions(const SessionOptions& options, const TlsNames& names = {});

}  // namespace sweepstake
