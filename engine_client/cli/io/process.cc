#include "engine_client/cli/io/process.h"

#include <grpc/support/log.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <iostream>

namespace sweepstake::cli {
namespace {

// Returns the default of ScreenSize if the size is unknown.
ScreenSize SizeOf(int descriptor) {
  winsize size{};
  const bool known =
      ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0;
  return known ? ScreenSize{size.ws_col, size.ws_row} : ScreenSize{};
}

volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t suspend_requested = 0;

void OnStop(int signal) {
  stop_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

int RunMain(int argc, char** argv, int (*run)(std::span<char* const> words, Terminal& terminal)) {
  // Turn off gRPC's log, because it only repeats errors that the commands report themselves.
  gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
  const bool err_is_tty = isatty(STDERR_FILENO) == 1;
  Terminal terminal{.out = std::cout,
                    .err = std::cerr,
                    .out_is_tty = isatty(STDOUT_FILENO) == 1,
                    .err_is_tty = err_is_tty,
                    .err_columns = err_is_tty ? SizeOf(STDERR_FILENO).columns : 0,
                    .out_size = [] { return SizeOf(STDOUT_FILENO); }};
  try {
    return run({argv, static_cast<size_t>(argc)}, terminal);
  } catch (const std::exception& error) {
    std::cerr << argv[0] << ": " << error.what() << '\n';
    return kCheckFailed;
  }
}

void InstallStopSignal() {
  std::signal(SIGINT, OnStop);
  std::signal(SIGTERM, OnStop);
}

bool StopRequested() { return stop_requested != 0; }

void CatchSuspendSignal() {
  std::signal(SIGTSTP, [](int /*signal*/) { suspend_requested = 1; });
}

bool SuspendRequested() { return suspend_requested != 0; }

void Suspend() {
  std::signal(SIGTSTP, SIG_DFL);
  std::raise(SIGTSTP);
  suspend_requested = 0;
  CatchSuspendSignal();
}

void ReleaseSuspendSignal() {
  std::signal(SIGTSTP, SIG_DFL);
  if (suspend_requested != 0) std::raise(SIGTSTP);
  suspend_requested = 0;
}

}  // namespace sweepstake::cli
