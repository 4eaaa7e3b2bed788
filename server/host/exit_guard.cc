#include "server/host/exit_guard.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace sweepstake::server {

ExitGuard::ExitGuard(std::chrono::milliseconds patience, int code, std::string message,
                     std::function<bool()> must_wait)
    : thread_([this, patience, code, text = std::move(message), wait = std::move(must_wait)] {
        std::unique_lock lock(mutex_);
        do {
          if (changed_.wait_for(lock, patience, [this] { return disarmed_; })) return;
        } while (wait());
        std::fprintf(stderr, "%s\n", text.c_str());
        std::_Exit(code);
      }) {}

ExitGuard::~ExitGuard() {
  {
    const std::lock_guard lock(mutex_);
    disarmed_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

}  // namespace sweepstake::server
