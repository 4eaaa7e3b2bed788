// Checks arguments of the caller: the address of a daemon and the options of a session. Pure
// functions.
#pragma once

#include <string>
#include <string_view>

#include "sweepstake/session.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Checks that an address has the form HOST:PORT. HOST is a host name, an IPv4 address or an [IPv6
// address]; PORT is 1 to 65535. For another form, returns kInvalidArgument with a message that
// describes the error.
Status ValidateDaemonAddress(std::string_view address);

// The names of the TLS options in error messages. The defaults are the names of the fields of
// TlsOptions. The command line passes the names of its own options.
struct TlsNames {
  std::string tls = "tls";
  std::string ca = "ca_file";
  std::string cert = "cert_file";
  std::string key = "key_file";
  std::string server_name = "server_name";
};

// Checks the options but not the files that they name. If an option is invalid, returns
// kInvalidArgument with its name and bounds.
Status ValidateTlsOptions(const TlsOptions& options, const TlsNames& names = {});

// Checks the options. If one is invalid, returns kInvalidArgument with its name and bounds.
Status ValidateSessionOptions(const SessionOptions& options, const TlsNames& names = {});

}  // namespace sweepstake
