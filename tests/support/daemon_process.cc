#include "tests/support/daemon_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

extern char** environ;

namespace sweepstake::test_support {
namespace {

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

[[noreturn]] void Die(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::abort();
}

pid_t Spawn(std::vector<std::string> arguments, const std::filesystem::path& log) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0600);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) Die("Cannot start " + arguments[0]);
  return pid;
}

// The port file appears, whole, once the daemon listens.
void WaitForPortFile(pid_t pid, const std::filesystem::path& port_file,
                     const std::filesystem::path& log) {
  while (!std::filesystem::exists(port_file)) {
    int status = 0;
    if (waitpid(pid, &status, WNOHANG) == pid) Die("The daemon ended at once:\n" + ReadFile(log));
    usleep(5'000);
  }
}

}  // namespace

DaemonProcess::DaemonProcess(const std::filesystem::path& data, const std::string& listen,
                             const std::vector<std::string>& more_arguments)
    : log_(data / "log") {
  const std::filesystem::path port_file = data / "port";
  std::filesystem::remove(port_file);
  std::vector<std::string> arguments = {SWEEPSTAKED_PATH,   "--listen",         listen,
                                        "--data",           data.string(),      "--port-file",
                                        port_file.string(), "--max-time-scale", "1000"};
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  pid_ = Spawn(std::move(arguments), log_);
  WaitForPortFile(pid_, port_file, log_);
  std::ifstream ports(port_file);
  std::string port;
  ports >> port;
  address_ = "127.0.0.1:" + port;
  if (int http_port = -1; ports >> http_port) http_port_ = http_port;
}

DaemonProcess::~DaemonProcess() {
  if (pid_ > 0) Kill();
}

std::string DaemonProcess::log() const { return ReadFile(log_); }

void DaemonProcess::Pause() { kill(pid_, SIGSTOP); }

void DaemonProcess::Kill() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

int DaemonProcess::Terminate() {
  kill(pid_, SIGTERM);
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  if (status != 0) std::fprintf(stderr, "The daemon's log:\n%s\n", log().c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace sweepstake::test_support
