#include "tests/support/daemon_process.h"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace sweepstake::test_support {
namespace {

std::vector<std::string> CommandLine(const std::filesystem::path& data,
                                     const std::filesystem::path& port_file,
                                     const std::string& listen,
                                     const std::vector<std::string>& more_arguments) {
  std::filesystem::remove(port_file);  // a former daemon's port file
  std::vector<std::string> arguments = {SWEEPSTAKED_PATH,   "--listen",         listen,
                                        "--data",           data.string(),      "--port-file",
                                        port_file.string(), "--max-time-scale", "1000"};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  return arguments;
}

}  // namespace

DaemonProcess::DaemonProcess(const std::filesystem::path& data, const std::string& listen,
                             const std::vector<std::string>& more_arguments)
    : process_(CommandLine(data, data / "port", listen, more_arguments), data / "log") {
  // The daemon writes the complete port file when it listens.
  while (!std::filesystem::exists(data / "port")) {
    if (process_.ended()) {
      std::fprintf(stderr, "The daemon did not start:\n%s\n", log().c_str());
      std::abort();
    }
    usleep(5'000);
  }
  std::ifstream ports(data / "port");
  std::string port;
  ports >> port;
  address_ = "127.0.0.1:" + port;
  if (int http_port = -1; ports >> http_port) http_port_ = http_port;
}

void DaemonProcess::Pause() const { process_.Signal(SIGSTOP); }

int DaemonProcess::Terminate() {
  const int exit_code = process_.Terminate();
  if (exit_code != 0) std::fprintf(stderr, "The daemon's log:\n%s\n", log().c_str());
  return exit_code;
}

}  // namespace sweepstake::test_support
