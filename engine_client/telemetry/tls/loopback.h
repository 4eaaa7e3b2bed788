// Decides which addresses belong to the same machine, so that plain text does not cross a network.
// The daemon and its clients share this rule.
#pragma once

#include <string>

namespace sweepstake::tls {

// Returns whether HOST:PORT is on the same machine: a numeric loopback address, or localhost. Other
// names are not resolved, because they may resolve to another machine at the next call. Even a name
// that begins with "127." may belong to another machine.
bool IsLoopback(const std::string& address);

}  // namespace sweepstake::tls
