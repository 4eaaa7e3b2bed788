// The program `sweepstake`. commands.h lists what it can do.
#include <grpc/support/log.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <exception>
#include <iostream>
#include <span>

#include "engine_client/cli/commands.h"

namespace sweepstake::cli {
namespace {

constexpr size_t kDefaultColumns = 80;

size_t ColumnsOfStderr() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kDefaultColumns;
}

int Run(std::span<char* const> words) {
  const bool err_is_tty = isatty(STDERR_FILENO) == 1;
  Terminal terminal{.out = std::cout,
                    .err = std::cerr,
                    .out_is_tty = isatty(STDOUT_FILENO) == 1,
                    .err_is_tty = err_is_tty,
                    .err_columns = err_is_tty ? ColumnsOfStderr() : 0};
  return RunCommandLine(words, terminal);
}

}  // namespace
}  // namespace sweepstake::cli

int main(int argc, char** argv) {
  // gRPC's own lines say nothing that the commands' messages do not.
  gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
  try {
    return sweepstake::cli::Run({argv, static_cast<size_t>(argc)});
  } catch (const std::exception& error) {
    std::cerr << "sweepstake: " << error.what() << '\n';
    return sweepstake::cli::kCheckFailed;
  }
}
