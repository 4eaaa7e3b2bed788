#include "server/host/descriptor_limit.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "absl/strings/str_cat.h"
#include "server/web/http_server.h"

namespace sweepstake::server {
namespace {

// Descriptors of the daemon itself: files, threads, listeners and HTTP connections.
constexpr uint64_t kOwnDescriptors = 256 + web::HttpLimits().max_connections;
// Descriptors for a connection of the daemon to itself: two ends, and the files of the host name
// lookup.
constexpr size_t kProbeDescriptors = 4;
// The client's socket, and the pair of local sockets of rpc::GuardedConnection.
constexpr uint64_t kDescriptorsPerConnection = 3;

}  // namespace

uint64_t RaiseDescriptorLimit() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlimit raised{.rlim_cur = limit.rlim_max, .rlim_max = limit.rlim_max};
  return setrlimit(RLIMIT_NOFILE, &raised) == 0 ? raised.rlim_cur : limit.rlim_cur;
}

std::optional<std::string> DescriptorShortage(uint64_t limit, const rpc::RpcOptions& options) {
  const uint64_t connections =
      uint64_t{options.max_sessions} + rpc::kMaxStreamsWithoutSession + options.max_watchers;
  const uint64_t needed = kDescriptorsPerConnection * connections + kOwnDescriptors;
  if (limit >= needed) return std::nullopt;
  return absl::StrCat("the limit of open files is ", limit, ", and ",
                      uint32_t{options.max_sessions}, " sessions may need ", needed,
                      "; raise it (LimitNOFILE of systemd, ulimit -n), or lower --max-sessions");
}

bool DescriptorsRanOut() {
  std::array<int, kProbeDescriptors> files{};
  bool ran_out = false;
  for (int& file : files) {
    file = open("/dev/null", O_RDONLY | O_CLOEXEC);
    ran_out = ran_out || (file < 0 && (errno == EMFILE || errno == ENFILE));
  }
  for (const int file : files) {
    if (file >= 0) close(file);
  }
  return ran_out;
}

}  // namespace sweepstake::server
