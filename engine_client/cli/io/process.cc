#include "engine_client/cli/io/process.h"

#include <grpc/support/log.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
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

// Any thread may run the handlers that set these flags.
std::atomic<bool> stop_requested = false;
std::atomic<bool> suspend_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a handler must not lock");

void OnStop(int signal) {
  stop_requested = true;
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

bool StopRequested() { return stop_requested; }

void CatchSuspendSignal() {
  struct sigaction action {};
  action.sa_handler = [](int /*signal*/) { suspend_requested = true; };
  // A write to the terminal must go on. ThreadSanitizer's std::signal does not set this.
  action.sa_flags = SA_RESTART;
  sigaction(SIGTSTP, &action, nullptr);
}

bool SuspendRequested() { return suspend_requested; }

void Suspend() {
  std::signal(SIGTSTP, SIG_DFL);
  std::raise(SIGTSTP);
  suspend_requested = false;
  CatchSuspendSignal();
}

void ReleaseSuspendSignal() {
  std::signal(SIGTSTP, SIG_DFL);
  if (suspend_requested) std::raise(SIGTSTP);
  suspend_requested = false;
}

}  // namespace sweepstake::cli
