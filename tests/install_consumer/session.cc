// A C++ game that starts a session with a daemon that does not exist, and ends it.
#include "sweepstake/adaptive_session.h"

int main() {
  auto game = sweepstake::AdaptiveSession::Create(sweepstake::MakeDaemonSession("127.0.0.1:1"));
  if (!game.ok()) return 1;
  game->session().Stop(0);
  return game->session().stats().state == sweepstake::ConnectionState::kClosed ? 0 : 1;
}
