#include "engine_client/telemetry/daemon_address.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>

namespace sweepstake {
namespace {

bool IsPort(std::string_view text) {
  uint32_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= 65535;
}

bool IsHost(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return false;
  }
  return !host.empty() && host.size() <= 253 && std::all_of(host.begin(), host.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
           c == '-' || c == '_' || c == ':';
  });
}

}  // namespace

Status ValidateDaemonAddress(std::string_view address) {
  const size_t colon = address.rfind(':');
  if (colon != std::string_view::npos && IsHost(address.substr(0, colon)) &&
      IsPort(address.substr(colon + 1))) {
    return {};
  }
  return {StatusCode::kInvalidArgument,
          "'" + std::string(address.substr(0, 300)) +
              "' is not an address; write HOST:PORT, as 127.0.0.1:7433"};
}

}  // namespace sweepstake
