#include "server/rpc/open_connections.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

absl::Status OpenConnections::Add(int descriptor) {
  Forget(descriptor);
  std::string name = name_of_(descriptor);
  std::string address = net::AddressOf(name);
  // Connections from this machine are not limited: all games behind a local proxy share its
  // address, and the daemon's own health probe comes from here too.
  if (address.empty() || net::IsLoopbackAddress(address) || is_own_(descriptor))
    return absl::OkStatus();
  const size_t most = size_t{options_.max_streams_per_address} + kSpare;
  const auto known = addresses_.find(address);
  if (known != addresses_.end() && known->second.descriptors.size() >= most) {
    if (const size_t count = CountOpen(address); count >= most) {
      return Refused(
          v1::ERROR_REASON_TOO_MANY_STREAMS,
          absl::StrCat("this address has ", count,
                       " open connections, the maximum (max_streams_per_address + ", kSpare,
                       "); close some, or raise max_streams_per_address on the daemon"));
    }
  }
  addresses_[address].descriptors.insert(descriptor);
  connections_[descriptor] = {std::move(name), std::move(address)};
  return absl::OkStatus();
}

void OpenConnections::Forget(int descriptor) {
  const auto connection = connections_.find(descriptor);
  if (connection == connections_.end()) return;
  const auto address = addresses_.find(connection->second.address);
  address->second.descriptors.erase(descriptor);
  if (address->second.descriptors.empty()) addresses_.erase(address);
  connections_.erase(connection);
}

size_t OpenConnections::CountOpen(const std::string& address) {
  Address& own = addresses_.at(address);
  const size_t known_count = own.descriptors.size();
  if (clock_.NowNs() < own.next_look_ns) return known_count;
  own.next_look_ns = clock_.NowNs() + kLookIntervalNs;
  std::vector<int> closed;
  for (const int descriptor : own.descriptors) {
    if (name_of_(descriptor) != connections_.at(descriptor).name) closed.push_back(descriptor);
  }
  for (const int descriptor : closed) Forget(descriptor);
  return known_count - closed.size();
}

}  // namespace sweepstake::rpc
