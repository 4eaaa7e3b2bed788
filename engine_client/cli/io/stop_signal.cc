#include "engine_client/cli/io/stop_signal.h"

#include <csignal>

namespace sweepstake::cli {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

void OnStop(int signal) {
  stop_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void InstallStopSignal() {
  std::signal(SIGINT, OnStop);
  std::signal(SIGTERM, OnStop);
}

bool StopRequested() { return stop_requested != 0; }

}  // namespace sweepstake::cli
