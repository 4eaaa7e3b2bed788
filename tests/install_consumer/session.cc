// A C++ game that starts a session with a daemon that does not exist, and ends it.
#include "sweepstake/session.h"

int main() {
  auto session = sweepstake::MakeDaemonSession("127.0.0.1:1", {});
  if (!session.ok()) return 1;
  auto adaptive = sweepstake::AdaptiveBroadPhase::Create({}, &(*session)->sink());
  if (!adaptive.ok() || !(*session)->Start(**adaptive).ok()) return 1;
  (*session)->Stop(0);
  return (*session)->stats().state == sweepstake::ConnectionState::kClosed ? 0 : 1;
}
