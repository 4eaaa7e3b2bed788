// The limit of open files, which bounds how many games can be connected: each needs a descriptor.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/rpc/common/options.h"

namespace sweepstake::server {

// Raises the process's soft limit to its hard one, which needs no rights, and returns the limit in
// force.
uint64_t RaiseDescriptorLimit();

// Says what to do if the limit is too low for what the options allow; else returns nothing.
std::optional<std::string> DescriptorShortage(uint64_t limit, const rpc::RpcOptions& options);

// Returns whether so few descriptors are free that the process cannot connect to itself.
bool DescriptorsRanOut();

}  // namespace sweepstake::server
