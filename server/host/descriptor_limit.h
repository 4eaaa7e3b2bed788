// The limit of open files. It bounds how many games can connect, since each needs a descriptor.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/rpc/common/options.h"

namespace sweepstake::server {

// Raises the process's soft limit to the hard limit, which needs no privileges. Returns the limit
// in effect.
uint64_t RaiseDescriptorLimit();

// Returns a warning if the limit is too low for the sessions that the options allow.
std::optional<std::string> DescriptorShortage(uint64_t limit, const rpc::RpcOptions& options);

// Returns whether too few descriptors are free for the process to connect to itself.
bool DescriptorsRanOut();

}  // namespace sweepstake::server
