#include "engine_client/telemetry/tls/loopback.h"

#include <arpa/inet.h>

namespace sweepstake::tls {

bool IsLoopback(const std::string& address) {
  const std::string host = address.substr(0, address.rfind(':'));
  in_addr number{};
  const bool is_number = inet_pton(AF_INET, host.c_str(), &number) == 1;
  return host == "localhost" || host == "[::1]" || (is_number && ntohl(number.s_addr) >> 24 == 127);
}

}  // namespace sweepstake::tls
