#include "server/rpc/common/peer_address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

#include "absl/strings/str_replace.h"

namespace sweepstake::rpc {
namespace {

constexpr std::string_view kIpv6 = "ipv6:";
constexpr size_t kNetworkBytes = 8;

}  // namespace

std::string AddressOf(std::string_view peer) {
  if (!peer.starts_with(kIpv6)) {
    return std::string(peer.starts_with("ipv4:") ? peer.substr(0, peer.rfind(':')) : peer);
  }
  // gRPC may escape the brackets.
  const std::string text =
      absl::StrReplaceAll(std::string(peer.substr(kIpv6.size())), {{"%5B", "["}, {"%5D", "]"}});
  const size_t end = text.find_first_of("%]");
  std::string host = text.substr(0, std::min(end, text.size()));
  if (host.starts_with('[')) host.erase(0, 1);
  in6_addr address{};
  if (inet_pton(AF_INET6, host.c_str(), &address) != 1) return std::string(peer);
  const auto* bytes = reinterpret_cast<const uint8_t*>(&address);
  if (IN6_IS_ADDR_V4MAPPED(&address)) {
    std::array<char, INET_ADDRSTRLEN> mapped{};
    inet_ntop(AF_INET, bytes + 12, mapped.data(), mapped.size());
    return std::string("ipv4:") + mapped.data();
  }
  if (IN6_IS_ADDR_LOOPBACK(&address)) return "ipv6:::1";
  std::fill_n(reinterpret_cast<uint8_t*>(&address) + kNetworkBytes, kNetworkBytes, uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> network{};
  inet_ntop(AF_INET6, &address, network.data(), network.size());
  return std::string(kIpv6) + network.data() + "/64";
}

bool IsLoopbackAddress(std::string_view address) {
  return address.starts_with("ipv4:127.") || address == "ipv6:::1" || address.starts_with("unix:");
}

}  // namespace sweepstake::rpc
