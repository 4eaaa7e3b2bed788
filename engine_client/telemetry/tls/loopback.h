// Which addresses are of the same machine, so that plain text to them crosses no network. One rule
// for the daemon and its clients.
#pragma once

#include <string>

namespace sweepstake::tls {

// Returns whether HOST:PORT is on the same machine. Names are not resolved, since they may mean
// another machine at the next call, and one may begin with "127." as well: only numeric addresses
// and localhost count.
bool IsLoopback(const std::string& address);

}  // namespace sweepstake::tls
