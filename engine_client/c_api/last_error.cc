// The message of the latest failure, of which a process has one copy for each thread. boundary.cc
// is compiled for the library of c_daemon.h too; this file is not.
#include <algorithm>
#include <array>

#include "sweepstake/c_api.h"

namespace {

thread_local std::array<char, 1024> last_error{};

}  // namespace

const char* swp_last_error(void) { return last_error.data(); }

void swp_set_last_error(const char* text, uint64_t size) {
  const uint64_t length = text == nullptr ? 0 : std::min<uint64_t>(size, last_error.size() - 1);
  std::copy_n(text, length, last_error.begin());
  last_error[length] = '\0';
}
