// The address and credentials with which a command connects to a daemon. A plain value.
#pragma once

#include <optional>
#include <string>

#include "sweepstake/session.h"

namespace sweepstake::cli {

struct DaemonOptions {
  std::string address;                           // HOST:PORT
  std::optional<TlsOptions> tls = std::nullopt;  // absent: plain text
  ClientToken token = {};                        // may be empty
};

}  // namespace sweepstake::cli
