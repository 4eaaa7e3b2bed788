#include "server/net/peer_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace sweepstake::net {
namespace {

constexpr std::string_view kIpv6 = "ipv6:";
constexpr std::string_view kLocal = "unix-abstract:";
constexpr size_t kNetworkBytes = 8;
constexpr size_t kSiteBytes = 6;

using NameOfSocket = int (*)(int descriptor, sockaddr* address, socklen_t* size);

// Returns the socket's address in gRPC's format, or an empty string.
std::string NameFrom(NameOfSocket name_of, int descriptor) {
  sockaddr_in6 address{};  // also large enough for an IPv4 address
  socklen_t size = sizeof address;
  if (name_of(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  std::array<char, INET6_ADDRSTRLEN> text{};
  const uint16_t port = ntohs(address.sin6_port);  // IPv4 and IPv6 have it at the same offset
  if (address.sin6_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(address).sin_addr;
    inet_ntop(AF_INET, &ipv4, text.data(), text.size());
    return absl::StrCat("ipv4:", text.data(), ":", port);
  }
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) {
    inet_ntop(AF_INET, &address.sin6_addr.s6_addr[12], text.data(), text.size());
    return absl::StrCat("ipv4:", text.data(), ":", port);
  }
  inet_ntop(AF_INET6, &address.sin6_addr, text.data(), text.size());
  return absl::StrCat("ipv6:%5B", text.data(), "%5D:", port);
}

std::string_view WithoutPort(std::string_view name) { return name.substr(0, name.rfind(':')); }

}  // namespace

std::string PeerOf(int descriptor) { return NameFrom(getpeername, descriptor); }

std::string LocalNameOf(std::string_view peer, uint64_t number) {
  return absl::StrCat(absl::string_view(peer.data(), peer.size()), "/", getpid(), "/", number);
}

std::string ClientOf(std::string_view peer) {
  if (!peer.starts_with(kLocal)) return std::string(peer);
  peer.remove_prefix(kLocal.size());
  return std::string(peer.substr(0, peer.find('/')));
}

bool ConnectsItself(int descriptor) {
  const std::string peer = PeerOf(descriptor);
  return !peer.empty() && WithoutPort(peer) == WithoutPort(NameFrom(getsockname, descriptor));
}

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

std::optional<std::string> NetworkNamed(std::string_view text) {
  const size_t slash = text.find('/');
  const std::string host(text.substr(0, slash));
  const std::string_view bits = slash == std::string_view::npos ? "" : text.substr(slash);
  in_addr ipv4{};
  if (inet_pton(AF_INET, host.c_str(), &ipv4) == 1) {
    if (!bits.empty() && bits != "/24") return std::nullopt;
    return absl::StrCat(host.substr(0, host.rfind('.')), ".0/24");
  }
  in6_addr ipv6{};
  if (inet_pton(AF_INET6, host.c_str(), &ipv6) != 1) return std::nullopt;
  if (!bits.empty() && bits != "/48" && bits != "/64") return std::nullopt;
  const std::string address = AddressOf(absl::StrCat(std::string(kIpv6), "[", host, "]:0"));
  if (!address.starts_with(kIpv6)) return NetworkNamed(address.substr(kIpv6.size()));
  std::fill_n(reinterpret_cast<uint8_t*>(&ipv6) + kSiteBytes, sizeof ipv6 - kSiteBytes, uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> network{};
  inet_ntop(AF_INET6, &ipv6, network.data(), network.size());
  return std::string(network.data()) + "/48";
}

std::string NetworkOf(std::string_view peer) {
  const std::string address = AddressOf(peer);
  const bool is_ip = address.starts_with("ipv4:") || address.starts_with(kIpv6);
  if (!is_ip || IsLoopbackAddress(address)) return {};
  return NetworkNamed(std::string_view(address).substr(kIpv6.size())).value_or("");
}

std::string ForwardedPeer(std::string_view peer, std::string_view forwarded_for) {
  const absl::string_view list(forwarded_for.data(), forwarded_for.size());
  std::string last(absl::StripAsciiWhitespace(list.substr(list.rfind(',') + 1)));  // npos + 1 is 0
  // Some proxies add the port, and brackets around an IPv6 address.
  if (last.starts_with('[')) last = last.substr(1, last.find(']') - 1);
  if (std::count(last.begin(), last.end(), ':') == 1) last.resize(last.find(':'));
  in_addr ipv4{};
  in6_addr ipv6{};
  if (!IsLoopbackAddress(AddressOf(peer)) || forwarded_for.empty()) return std::string(peer);
  if (inet_pton(AF_INET, last.c_str(), &ipv4) == 1) return absl::StrCat("ipv4:", last, ":0");
  if (inet_pton(AF_INET6, last.c_str(), &ipv6) == 1)
    return absl::StrCat(std::string(kIpv6), "%5B", last, "%5D:0");
  return "ipv4:0.0.0.0:0";
}

bool IsLoopbackAddress(std::string_view address) {
  return address.starts_with("ipv4:127.") || address == "ipv6:::1" || address.starts_with("unix:");
}

}  // namespace sweepstake::net
