#include "server/rpc/open_connections.h"

#include "absl/strings/str_cat.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

absl::StatusOr<std::string> OpenConnections::Add(std::string_view peer, bool is_own) {
  std::string address = net::AddressOf(peer);
  // Connections from this machine are not limited: all games behind a local proxy share its
  // address, and the daemon's own health probe comes from here too.
  if (address.empty() || net::IsLoopbackAddress(address) || is_own) return std::string();
  uint32_t& count = counts_[address];
  if (count >= options_.max_streams_per_address + kSpare) {
    return Refused(
        v1::ERROR_REASON_TOO_MANY_STREAMS,
        absl::StrCat("this address has ", count,
                     " open connections, the maximum (max_streams_per_address + ", kSpare,
                     "); close some, or raise max_streams_per_address on the daemon"));
  }
  ++count;
  return address;
}

void OpenConnections::Remove(const std::string& address) {
  const auto found = counts_.find(address);
  if (found != counts_.end() && --found->second == 0) counts_.erase(found);
}

}  // namespace sweepstake::rpc
